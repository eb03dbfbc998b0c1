-- threat: the script is out of memory while variables are being closed
-- expect: any
local function deep(n)
  local _ <close> = setmetatable({}, { __close = function() local t = {} for i = 1, 1e6 do t[i] = { i } end end })
  if n > 0 then deep(n - 1) end
  error "down"
end
print(pcall(deep, 30))
