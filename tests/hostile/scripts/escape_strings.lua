-- threat: the metatable of strings is out of reach, and what is replaced does not change messages
-- expect: error
assert(getmetatable("") == false and not pcall(setmetatable, "", {}))
string.format, string.sub, tostring, type, select = nil, nil, nil, nil, nil
error "the true message"
