-- threat: no error object at all
-- expect: error
for _, v in ipairs { false, 0, {}, print } do pcall(error, v) end
error(nil)
