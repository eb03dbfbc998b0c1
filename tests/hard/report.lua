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
  if not measured(other) then return cell("none: " .. other.why) end
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
