-- tests/accuracy/report_plot.lua - work-precision plots by gnuplot: one panel per scene, digbox in colour over its peers in grey.
local plot = {}

local x_low, x_high = 0.01, 300                  -- CPU ms per simulated second; 1e4 where the rows need it
local y_low, y_high = 1e-17, 10                  -- error; anything smaller than `nothing` is drawn there
local nothing, most = 1e-16, 3

-- Open and filled point types of gnuplot's svg terminal
local looks = {
  bullet   = { open = 8,  full = 9,  colour = "#b4b4b4" },
  bullet64 = { open = 10, full = 11, colour = "#989898" },
  ode      = { open = 4,  full = 5,  colour = "#7a7a7a" },
  mujoco   = { open = 12, full = 13, colour = "#505050" },
}
local blue, orange, green = "#1c5fd4", "#e8590c", "#2b8a3e"

local function at(row)
  return math.min(math.max(row.ms, x_low), x_high), math.min(math.max(row.error, nothing), most)
end

local function points(rows)
  local text = {}
  for _, row in ipairs(rows) do
    if row.error < math.huge then text[#text + 1] = ("%.3g %.2g"):format(at(row)) end
  end
  return text
end

-- A peer's settings of one kind ("RK4", "it100", "direct", or nothing after the rate) make one line each.
local function families(rows)
  local list, by = {}, {}
  for _, row in ipairs(rows) do
    local kind = row.setting:match "Hz *(.*)$" or ""
    if not by[kind] then
      by[kind] = {}
      list[#list + 1] = by[kind]
    end
    table.insert(by[kind], row)
  end
  for _, family in ipairs(list) do table.sort(family, function(a, b) return a.ms < b.ms end) end
  return list
end

-- ---- labels ----
local panel = { width = 250, height = 225, right = 12, top = 22 }        -- pixels, with what stays free at the right and the top

-- Where a point of a panel is, in pixels from the panel's lower left corner
local function pixel(x, y)
  local function part(value, low, high) return math.log(value / low) / math.log(high / low) end
  return part(x, x_low, x_high) * (panel.width - panel.right), part(y, y_low, y_high) * (panel.height - panel.top)
end

-- Plans that stand together share a label; the best of the peers has one too.
local function groups(item, plans)
  local list = {}
  for _, name in ipairs(plans) do
    local row = item.plans[name]
    if row and row.error < math.huge then
      local x, y = pixel(at(row))
      local joined
      for _, group in ipairs(list) do
        if not joined and math.abs(x - group.x) < 45 and math.abs(y - group.y) < 9 then
          group.names[#group.names + 1] = name
          joined = true
        end
      end
      if not joined then list[#list + 1] = { x = x, y = y, names = { name } } end
    end
  end
  for _, group in ipairs(list) do
    group.text = #group.names == #plans and "all plans" or table.concat(group.names, ", ")
    group.colour = (", " .. table.concat(group.names, ", ") .. ","):find(" play,", 1, true) and orange or blue
  end
  local best, name
  for _, peer in ipairs(item.peers) do
    for _, row in ipairs(peer.rows) do
      if not best or row.error < best.error then best, name = row, peer.engine.name end
    end
  end
  if best and best.error < math.huge then
    local x, y = pixel(at(best))
    list[#list + 1] = { x = x, y = y, text = name .. ", " .. best.setting, colour = "#606060", peer = true }
  end
  return list
end

-- Small boxes along a line, which a label should not hide
local function along(boxes, rows)
  for i, row in ipairs(rows) do
    local x0, y0 = pixel(at(rows[math.max(1, i - 1)]))
    local x1, y1 = pixel(at(row))
    for part = 0, 1, 0.1 do
      local x, y = x0 + part * (x1 - x0), y0 + part * (y1 - y0)
      boxes[#boxes + 1] = { x0 = x - 2, x1 = x + 2, y0 = y - 2, y1 = y + 2 }
    end
  end
end

local function overlap(a, b) return a.x0 < b.x1 and b.x0 < a.x1 and a.y0 < b.y1 and b.y0 < a.y1 end

-- Beside its point, wherever it hides no other label or plan; a label that finds no place is left out.
local function place_labels(item, plans)
  local list, taken = groups(item, plans), {}
  for _, name in ipairs(plans) do
    local row = item.plans[name]
    if row and row.error < math.huge then
      local x, y = pixel(at(row))
      taken[#taken + 1] = { x0 = x - 3, x1 = x + 3, y0 = y - 3, y1 = y + 3 }
    end
  end
  local placed = {}
  for _, group in ipairs(list) do
    local text = group.text
    if group.peer then
      along(taken, item.ladder)
      for _, goal in pairs(item.goal or {}) do along(taken, { { ms = goal[2], error = goal[1] } }) end
      for _, peer in ipairs(item.peers) do
        for _, family in ipairs(families(peer.rows)) do along(taken, family) end
      end
    end
    local w = 4.9 * #text
    local ways = { { 6, 5 }, { 6, -6 }, { -6 - w, 5 }, { -6 - w, -6 }, { 8, 0 }, { -8 - w, 0 }, { 6, 13 }, { 6, -14 }, { -6 - w, -14 } }
    for _, way in ipairs(ways) do
      local x, y = group.x + way[1], group.y + way[2]
      local box = { x0 = x, x1 = x + w, y0 = y - 4.5, y1 = y + 4.5 }
      local free = x > 0 and x + w < panel.width - panel.right and y > 5 and y < panel.height - panel.top - 6
      for _, other in ipairs(taken) do free = free and not overlap(box, other) end
      if free then
        taken[#taken + 1] = box
        placed[#placed + 1] = { text = text, x = x, y = y, colour = group.colour }
        break
      end
    end
  end
  return placed
end

local Script = {}
Script.__index = Script

function Script:say(...) self.lines[#self.lines + 1] = string.format(...) end

-- Declares a block of data and adds a curve of it to the panel; nothing when there is none
function Script:curve(data, style)
  if #data == 0 then return end
  self.blocks = self.blocks + 1
  local name = "$d" .. self.blocks
  self:say("%s << E\n%s\nE", name, table.concat(data, "\n"))
  table.insert(self.curves, ("%s %s notitle"):format(name, style))
end

function Script:panel(item, o)
  self.curves = {}
  for _, peer in ipairs(item.peers) do
    local look = looks[peer.engine.id]
    for _, family in ipairs(families(peer.rows)) do
      self:curve(points(family), ("w lp lc rgb '%s' lw 0.7 pt %d ps 0.45"):format(look.colour, look.open))
    end
    self:curve(points { peer.rows[1] }, ("w p lc rgb '%s' pt %d ps 0.85"):format(look.colour, look.full))
  end
  if item.goal then
    local goals = {}
    for _, goal in pairs(item.goal) do goals[#goals + 1] = { ms = goal[2], error = goal[1] } end
    table.sort(goals, function(a, b) return a.ms < b.ms end)
    self:curve(points(goals), ("w p lc rgb '%s' lw 2 pt 1 ps 1"):format(green))
  end
  self:curve(points(item.ladder), ("w lp lc rgb '%s' lw 1.6 pt 7 ps 0.3"):format(blue))
  local plans = {}
  for _, name in ipairs(o.plans) do
    if name ~= "play" then plans[#plans + 1] = item.plans[name] end
  end
  self:curve(points(plans), ("w p lc rgb '%s' pt 7 ps 0.8"):format(blue))
  self:curve(points { item.plans.play }, ("w p lc rgb '%s' pt 7 ps 1.1"):format(orange))
  self:say "unset label"
  for i, label in ipairs(place_labels(item, o.plans)) do
    self:say("set label %d '%s' at graph %.3f,%.3f left font ',8' tc rgb '%s' front", i, label.text,
      label.x / (panel.width - panel.right), label.y / (panel.height - panel.top), label.colour)
  end
  if o.legend then self:legend(o) end
  self:say("set title '{/:Bold %s} %s'", item.id, (item.title:gsub("'", "''")))
  self:say("plot %s", #self.curves > 0 and table.concat(self.curves, ", ") or "NaN notitle")
end

-- The legend stands in the free panels at the end of the last row.
function Script:legend(o)
  local entries = { { "digbox, the default plan: play", orange, 7, 1.1 }, { "digbox, other plans", blue, 7, 0.8 },
                    { "digbox, tolerances 1e-2 to 1e-12", blue, 7, 0.3, true }, { "goals of digbox", green, 1, 1 } }
  for _, engine in ipairs(o.shown) do
    local look = looks[engine.id]
    entries[#entries + 1] = { engine.name .. ", its default", look.colour, look.full, 0.85 }
    entries[#entries + 1] = { engine.name .. ", other settings", look.colour, look.open, 0.45, true }
  end
  local left, top = o.legend[1] + 20 / o.width, o.legend[2] - 42 / o.height
  for i, entry in ipairs(entries) do
    local y = top - 15 / o.height * (i - 1)
    if entry[5] then
      self:say("set arrow %d from screen %.4f,%.4f to screen %.4f,%.4f nohead lc rgb '%s' lw 1.2", 100 + i, left, y,
        left + 24 / o.width, y, entry[2])
    end
    self:say("set label %d '' at screen %.4f,%.4f point lc rgb '%s' pt %d ps %.2f front", 100 + i, left + 12 / o.width, y, entry[2],
      entry[3], entry[4])
    self:say("set label %d '%s' at screen %.4f,%.4f left font ',9' front", 200 + i, entry[1], left + 32 / o.width, y)
  end
  local words = { "Lower is more accurate, further left is faster." }
  if #o.shown > 0 then words[2] = "In grey words: the most accurate of the others." end
  for i, line in ipairs(words) do
    self:say("set label %d '%s' at screen %.4f,%.4f left font ',9' front", 300 + i, line, left, top - 15 / o.height * (#entries + i - 0.7))
  end
end

function Script:page(items, o)
  local columns = o.columns
  local rows = math.ceil((#items + 1) / columns)
  o.width, o.height = columns * panel.width + 60, rows * panel.height + 50
  local left, bottom = 48 / o.width, 40 / o.height
  local w, h = panel.width / o.width, panel.height / o.height
  self:say("set multiplot")
  self:say("set logscale xy; set xrange [%g:%g]; set yrange [%g:%g]", x_low, x_high, y_low, y_high)
  self:say "set grid xtics ytics lt 1 lw 0.4 lc rgb '#e4e4e4'; set border lw 0.6 lc rgb '#808080'; unset key"
  self:say "set tics scale 0.4 nomirror font ',8'; set mxtics 1; set mytics 1; set title font ',8' offset 0,-0.7"
  for i, item in ipairs(items) do
    local column, row = (i - 1) % columns, (i - 1) // columns
    local below = i + columns > #items
    local x0, y0 = left + column * w, bottom + (rows - 1 - row) * h
    self:say("set lmargin at screen %.4f; set rmargin at screen %.4f", x0, x0 + w - panel.right / o.width)
    self:say("set bmargin at screen %.4f; set tmargin at screen %.4f", y0, y0 + h - panel.top / o.height)
    local ticks = "'%s' 0.01, '%s' 0.1, '%s' 1, '%s' 10, '%s' 100, '%s' 1000"
    ticks = below and ticks:format("0.01", "0.1", "1", "10", "100", "1000") or ticks:gsub("%%s", "")
    self:say("set xtics (%s); set xlabel '%s' font ',9' offset 0,0.6", ticks, below and "CPU ms per simulated s" or "")
    local marks = {}
    for power = -16, 0, 4 do
      marks[#marks + 1] = ("'%s' 1e%d"):format(column == 0 and (power == 0 and "1" or "1e" .. power) or "", power)
    end
    self:say("set ytics (%s); set ylabel '%s' font ',9' offset 2.5,0", table.concat(marks, ", "), column == 0 and "error" or "")
    o.legend = i == #items and { left + (#items % columns) * w, bottom + h }
    self:panel(item, o)
    self:say "unset arrow"
  end
  self:say "unset multiplot"
end

-- Leaves out of gnuplot's SVG what does not show: names and groups of nothing, defaults, hundredths of a pixel.
local function slim(path)
  local file = assert(io.open(path))
  local head, text = file:read "a":match "^(.-)(<svg.*)$"
  file:close()
  text = text:gsub("<title>gnuplot_plot[^<]*</title>", ""):gsub(' id="gnuplot_plot[^"]*" ?', "")
  text = text:gsub(' stroke%-linecap="butt" stroke%-linejoin="miter"', "")
  for _, place in ipairs { "(d=)(%b'')", "(translate)(%b())", "(scale)(%b())" } do
    text = text:gsub(place, function(what, numbers)
      return what .. numbers:gsub("(%d%.%d)%d", "%1"):gsub("%.0([ ,'\")])", "%1"):gsub(" +'", "'")
    end)
  end
  text = text:gsub("\t", ""):gsub("'rgb%( *(%d+), *(%d+), *(%d+)%)'", function(r, g, b) return ("'#%02x%02x%02x'"):format(r, g, b) end)
  text = text:gsub('"rgb%( *(%d+), *(%d+), *(%d+)%)"', function(r, g, b) return ('"#%02x%02x%02x"'):format(r, g, b) end)
  text = text:gsub('<tspan font%-family="sans%-serif" *>([^<]*)</tspan>', "%1"):gsub(' font%-family="sans%-serif"', "")
  text = text:gsub('<g fill="none" color="black" stroke="currentColor"', "<g"):gsub("<text>%s*</text>", "")
  text = text:gsub("<svg ", '<svg font-family="sans-serif" fill="none" stroke="currentColor" ', 1):gsub("<rect ", '<rect stroke="none" ', 1)
  text = text:gsub("gpPt", "p"):gsub("(<use xlink:href='#p%d+') transform='(%S+) (%S+)'", "%1 transform='%2%3'")
  local count
  repeat text, count = text:gsub("<g[^>]*>%s*</g>%s*", "") until count == 0
  text = text:gsub("\n%s*\n+", "\n"):gsub(" +>", ">"):gsub(" +/>", "/>"):gsub('class="gridline" *', "")
  file = assert(io.open(path, "w"))
  file:write(head, text)
  file:close()
end

-- items: as report.lua gathers them; o: svg, png and script (paths), columns, plans, engines
function plot.draw(items, o)
  o.shown, x_high = {}, 300
  for _, item in ipairs(items) do
    for _, rows in pairs(item.rows) do
      for _, row in ipairs(rows) do
        if row.ms > x_high then x_high = 1e4 end
      end
    end
  end
  for _, engine in ipairs(o.engines) do
    for _, item in ipairs(items) do
      if item.rows[engine.id] then
        o.shown[#o.shown + 1] = engine
        break
      end
    end
  end
  local page = setmetatable({ lines = {}, blocks = 0 }, Script)
  page:page(items, o)
  local file = assert(io.open(o.script, "w"))
  for kind, path in pairs { svg = o.svg, png = o.png } do
    local terminal = kind == "svg" and ("svg size %d,%d font 'sans-serif,10' background 'white'"):format(o.width, o.height)
      or ("pngcairo size %d,%d font 'sans,10' background 'white'"):format(o.width, o.height)
    file:write(("reset session\nset encoding utf8\nset terminal %s\nset output '%s'\n"):format(terminal, path))
    file:write(table.concat(page.lines, "\n"), "\nunset output\n")
  end
  file:close()
  if not os.execute(("gnuplot '%s'"):format(o.script)) then
    io.stderr:write("accuracy: gnuplot did not draw ", o.svg, "\n")
    os.exit(1)
  end
  slim(o.svg)
end

return plot
