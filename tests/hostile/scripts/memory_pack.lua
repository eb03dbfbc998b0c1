-- threat: string.pack of two gigabytes of padding
-- expect: limit
return #string.pack("c2000000000", "")
