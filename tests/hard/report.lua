-- tests/hard/report.lua - writes the table of the hard cases from the rows that run.lua printed, those of other engines beside.
--
--   lua5.4 tests/hard/report.lua build/hard docs/stability.md      the part between its two marks; a new file gets a head
--
-- Rows are in FOLDER/rows/*.tsv and, of other engines, in FOLDER/peers/rows/*.tsv.
local folder, target = arg[1], arg[2]

local names = { "id", "title", "step", "verdict", "worst", "value", "limit", "margin", "always", "dearest", "place", "ms", "shares",
  "gave_up", "why", "rejected", "residual", "penetration", "joint_error", "time" }
local begin_mark, end_mark = "<!-- figures: begin -->", "<!-- figures: end -->"

local peer_names = { "id", "step", "engine", "verdict", "worst", "value", "limit", "ms", "why" }
local peers = { { "bullet", "Bullet" }, { "ode", "ODE" }, { "mujoco", "MuJoCo" } }

local function read_lines(pattern, fields)
  local list = {}
  local pipe = assert(io.popen(("cat %s/%s 2>/dev/null"):format(folder, pattern)))
  for line in pipe:lines() do
    local row, i = {}, 0
    for field in (line .. "\t"):gmatch "([^\t]*)\t" do
      i = i + 1
      row[fields[i] or i] = field
    end
    if row.id and row.id:match "^B%d%d" then list[#list + 1] = row end
  end
  pipe:close()
  return list
end

-- What the other engines made of a case: row.peers.ode
local function add_peers(list)
  local by_run = {}
  for _, row in ipairs(list) do
    row.peers = {}
    by_run[row.id .. " " .. row.step] = row
  end
  for _, other in ipairs(read_lines("peers/rows/*.tsv", peer_names)) do
    local row = by_run[other.id .. " " .. other.step]
    if row then row.peers[other.engine] = other end
  end
end

local function read_rows()
  local list = read_lines("rows/*.tsv", names)
  add_peers(list)
  local rank = { ["1/30"] = 1, ["1/60"] = 2, ["1/1000"] = 3 }
  table.sort(list, function(a, b)
    if a.id ~= b.id then return a.id < b.id end
    return (rank[a.step] or 4) < (rank[b.step] or 4)
  end)
  return list
end

local function short(x)
  local n = tonumber(x)
  return n and n == n and ("%.2g"):format(n) or x
end

local function cell(text) return (text:gsub("|", "\\|")) end

local function why(row)
  local parts = {}
  if row.verdict == "over time" then parts[#parts + 1] = ("stopped at %s s"):format(row.time or "?") end
  if row.why and row.why ~= "" then parts[#parts + 1] = ("left a finer way %s times, last: %s"):format(row.gave_up, row.why) end
  return table.concat(parts, "; ")
end

-- ---- other engines ----

local function measured(other) return other and other.verdict ~= "none" and other.verdict ~= "error" end

local function peer_cell(row, engine)
  local other = row.peers[engine]
  if not other then return "" end
  if not measured(other) then return cell(other.verdict .. ": " .. other.why) end
  local what = other.worst == row.worst and "" or "(" .. other.worst .. ") "
  if other.value == "" then return cell(other.verdict .. ": " .. other.why) end
  return cell(("%s %s%s; %s ms/s"):format(other.verdict, what, short(other.value), short(other.ms)))
end

-- ms/s of the cheapest other engine that passes, or nil
local function cheapest(row)
  local least
  for _, other in pairs(row.peers) do
    local ms = other.verdict == "pass" and tonumber(other.ms)
    if ms and (not least or ms < least) then least = ms end
  end
  return least
end

local function thrift(row)
  local least = cheapest(row)
  if not least then return next(row.peers) and "no peer passes" or "" end
  return row.verdict == "pass" and tonumber(row.ms) <= least and "yes" or "**no**"
end

-- One sentence on the runs that all engines were given and could express
local function summary(list, add)
  local present, common, within, contested = {}, 0, 0, 0
  local passes = { digbox = 0 }
  for _, row in ipairs(list) do
    for engine in pairs(row.peers) do present[engine] = true end
  end
  for _, row in ipairs(list) do
    local all = next(row.peers) ~= nil
    for engine in pairs(present) do all = all and measured(row.peers[engine]) end
    if all then
      common = common + 1
      passes.digbox = passes.digbox + (row.verdict == "pass" and 1 or 0)
      for engine in pairs(present) do
        passes[engine] = (passes[engine] or 0) + (row.peers[engine].verdict == "pass" and 1 or 0)
      end
    end
    if cheapest(row) then
      contested = contested + 1
      if thrift(row) == "yes" then within = within + 1 end
    end
  end
  if common == 0 then return end
  local parts = {}
  for _, peer in ipairs(peers) do
    if present[peer[1]] then parts[#parts + 1] = ("%s %d"):format(peer[2], passes[peer[1]]) end
  end
  add ""
  add("Of the %d runs that the other engines could be given as well, digbox passes %d, %s; " ..
    "in %d of the %d runs that another engine passes digbox passes and costs no more than the cheapest of these.", common, passes.digbox,
    table.concat(parts, ", "), within, contested)
  add ""
  add("The others run the same cases, judged by the same criteria (tests/hard/peers), each at its own default: Bullet in float, 10 " ..
    "iterations, its continuous collision detection on for bodies that pass their own size in a frame; ODE with its quick step, 20 " ..
    "iterations; both with one step a frame; MuJoCo with its step of 2 ms, as 1/480 s or the next smaller part of the frame, jointed " ..
    "bodies as joints of its tree. No damping, no sleep. Where bodies bounce, Bullet has the settings its users are advised to take, " ..
    "and MuJoCo, which has no restitution, springs and dampers of that ratio. A cell names its criterion where it is not the one of the " ..
    "row. Left out of their judgement: what digbox says of itself (B19, B30 events), the work of motors (B28b), forces of hinges in " ..
    "MuJoCo (B20). In float a change of 1e-9 is mostly none at all (Bullet in B30).")
end

-- ---- the cheapest setting of any engine ----

-- Box3D, Jolt, Bullet, ODE and MuJoCo, each at its default and at finer settings, were run on scenes like these before digbox was
-- begun: the cheapest setting of all that passed, by criteria that are looser than those here, in ms of one core of a machine like
-- that of the runs here for a simulated second. { its scene, engine and setting, ms/s, the case here }
local cheapest_of_all = {
  { "1000 kg on five boxes of 1 kg", "Jolt, 4 steps a frame, 40 and 8 iterations", 4.67, "B01c" },
  { "100 kg on five boxes of 1 kg", "Jolt, 4 steps a frame", 1.73, "B01b" },
  { "tower of 40 boxes", "Box3D, default", 2.51, "B02b" },
  { "chain of 50 links, end 1000:1", "Jolt, 64 steps a frame", 114, "B04b" },
  { "chain of 50 links, end 100:1", "Jolt, 16 steps a frame", 29, "B04a" },
  { "house of 14 cards (15 here)", "Jolt, default", 1.59, "B07a" },
  { "bullet on a wall of 2 cm (100 at once here: a hundredth)", "Bullet, default", 0.14, "B09", 100 },
  { "eight boxes in one place", "Box3D in double, default", 0.94, "B08" },
  { "three spheres, restitution 0", "Jolt, default", 0.15, "B25a" },
  { "three spheres, restitution 0.8", "Jolt, default", 0.17, "B25b" },
  { "rotor, a million frames", "MuJoCo, RK4 at 480 Hz", 1.57, "B14a" },
  { "10 km from the origin", "Box3D in double, default", 0.67, "B16a" },
  { "100 km from the origin", "Box3D in double, default", 0.68, "B16b" },
  { "1000 km from the origin", "Box3D in double, default", 0.67, "B16c" },
  { "box squeezed to half its size", "Jolt, default", 0.22, "B19a" },
  { "box at 100 turns a second", "ODE, default", 0.06, "B13a" },
  { "four-bar linkage", "MuJoCo, Euler at 60 Hz", 0.16, "B20a" },
}

local function write_cheapest(list, add)
  local by_id, lines, within = {}, {}, 0
  for _, row in ipairs(list) do by_id[row.id] = row end
  for _, bar in ipairs(cheapest_of_all) do
    local scene, engine, ms, id, shares = table.unpack(bar)
    local row = by_id[id]
    if row then
      local own = tonumber(row.ms) / (shares or 1)
      local good = row.verdict == "pass" and own <= ms
      within = within + (good and 1 or 0)
      lines[#lines + 1] = ("| %s | %s | %s | %s | %s | %s |"):format(scene, engine, short(ms), id, short(own), good and "yes" or "**no**")
    end
  end
  if #lines == 0 then return end
  add ""
  add "### Beside the cheapest setting of any engine that passes"
  add ""
  add("Box3D, Jolt, Bullet, ODE and MuJoCo were run on scenes like these before digbox was begun, each at its default and at finer " ..
    "settings, and judged by criteria looser than those here. In %d of %d digbox, at its default, costs no more than the cheapest " ..
    "setting of all that passed there (another machine of the same kind: read one digit).", within, #lines)
  add ""
  add "| scene | cheapest that passed | its ms/s | case here | digbox, ms/s | at or below |"
  add "|---|---|---:|---|---:|---|"
  for _, line in ipairs(lines) do add("%s", line) end
end

local function write_table(list, add)
  add("| case | step | verdict | criterion nearest to failing | measured | limit | limit / measured | always | dearest frame / median | " ..
    "ms/s | traced/conserved/swept, %s | Bullet | ODE | MuJoCo | cost at or below the cheapest passing peer |", "%")
  add "|---|---|---|---|---:|---:|---:|---|---:|---:|---|---|---|---|---|"
  for _, r in ipairs(list) do
    local verdict = r.verdict == "pass" and "pass" or "**" .. r.verdict .. "**"
    local most = (r.limit or ""):gsub("<= ", "")
    add("| %s %s | %s | %s | %s | %s | %s | %s | %s | %s | %s | %s | %s | %s | %s | %s |", r.id, cell(r.title), r.step, verdict,
      cell(r.worst or ""), short(r.value), most, short(r.margin), cell(r.always or ""), short(r.dearest), short(r.ms), r.shares or "",
      peer_cell(r, "bullet"), peer_cell(r, "ode"), peer_cell(r, "mujoco"), thrift(r))
  end
end

-- Other frame steps: what the issue is judged by, without costs and other engines.
local function write_compact(list, add)
  add "| case | verdict | criterion nearest to failing | measured | limit | always |"
  add "|---|---|---|---:|---:|---|"
  for _, r in ipairs(list) do
    local verdict = r.verdict == "pass" and "pass" or "**" .. r.verdict .. "**"
    add("| %s %s | %s | %s | %s | %s | %s |", r.id, cell(r.title), verdict, cell(r.worst or ""), short(r.value),
      ((r.limit or ""):gsub("<= ", "")), cell(r.always or ""))
  end
end

local function write_failures(list, add)
  add ""
  add "### What fails"
  add ""
  add "| case | step | verdict | criterion | measured, limit | what must always hold | what the world says |"
  add "|---|---|---|---|---|---|---|"
  for _, r in ipairs(list) do
    if r.verdict ~= "pass" or r.always ~= "ok" then
      local own = r.verdict ~= "pass"
      add("| %s | %s | %s | %s | %s | %s | %s |", r.id, r.step, r.verdict, own and cell(r.worst or "") or "",
        own and short(r.value) .. ", " .. (r.limit or "") or "", r.always == "ok" and "" or cell(r.always or ""), cell(why(r)))
    end
  end
end

-- The rows of one frame step, and one sentence on them
local function at_step(list, step, add)
  local some, passed, fine = {}, 0, 0
  for _, r in ipairs(list) do
    if r.step == step then
      some[#some + 1] = r
      passed, fine = passed + (r.verdict == "pass" and 1 or 0), fine + (r.always == "ok" and 1 or 0)
    end
  end
  if #some > 0 then
    add ""
    add("### At %s s", step)
    add ""
    add("%d cases: %d pass their own criteria; in %d all of G1 to G8 hold.", #some, passed, fine)
  end
  return some
end

local function figures(list)
  local out = {}
  local function add(format, ...) out[#out + 1] = select("#", ...) > 0 and format:format(...) or format end
  local usual = at_step(list, "1/60", add)
  summary(usual, add)
  add ""
  if #usual > 0 then write_table(usual, add) end
  write_cheapest(usual, add)
  for _, step in ipairs { "1/30", "1/1000" } do
    local some = at_step(list, step, add)
    add ""
    if #some > 0 then write_compact(some, add) end
  end
  write_failures(list, add)
  return table.concat(out, "\n")
end

local function read_file(path)
  local file = io.open(path)
  local text = file and file:read "a"
  if file then file:close() end
  return text
end

local list = read_rows()
if #list == 0 then
  io.stderr:write("hard-cases: no rows in ", folder .. "/rows", "\n")
  os.exit(1)
end
local text = read_file(target) or "# Stability\n\n" .. begin_mark .. "\n" .. end_mark .. "\n"
local from, to = text:find(begin_mark, 1, true), text:find(end_mark, 1, true)
if not from or not to then
  io.stderr:write("hard-cases: ", target, " has no marks for the figures\n")
  os.exit(1)
end
local file = assert(io.open(target, "w"))
file:write(text:sub(1, from + #begin_mark - 1), "\n", figures(list), "\n", text:sub(to))
file:close()
