-- threat: sizes and alignments at the edge
-- expect: ok
for _, f in ipairs { "i17", "!32i4", "c", "s9", "c99999999999999999999", "Xi", "z\0", "j!j!" } do print(pcall(string.packsize, f)) end
print "fine"
