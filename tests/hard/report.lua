-- tests/hard/report.lua - writes the table of the hard cases from the rows that run.lua printed.
--
--   lua5.4 tests/hard/report.lua build/hard/rows docs/stability.md      the part between its two marks; a new file gets a head
local rows_folder, target = arg[1], arg[2]

local names = { "id", "title", "step", "verdict", "worst", "value", "limit", "margin", "always", "dearest", "place", "ms", "shares",
  "gave_up", "why", "rejected", "residual", "penetration", "joint_error", "time" }
local begin_mark, end_mark = "<!-- figures: begin -->", "<!-- figures: end -->"

local function read_rows()
  local list = {}
  local pipe = assert(io.popen(("cat %s/*.tsv"):format(rows_folder)))
  for line in pipe:lines() do
    local row, i = {}, 0
    for field in (line .. "\t"):gmatch "([^\t]*)\t" do
      i = i + 1
      row[names[i] or i] = field
    end
    if row.id and row.id:match "^B%d%d" then list[#list + 1] = row end
  end
  pipe:close()
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

local function write_table(list, add)
  add("| case | step | verdict | criterion nearest to failing | measured | limit | limit / measured | always | dearest frame / median | " ..
    "ms/s | traced/conserved/swept, %s | Bullet | ODE | MuJoCo |", "%")
  add "|---|---|---|---|---:|---:|---:|---|---:|---:|---|---|---|---|"
  for _, r in ipairs(list) do
    local verdict = r.verdict == "pass" and "pass" or "**" .. r.verdict .. "**"
    local most = (r.limit or ""):gsub("<= ", "")
    add("| %s %s | %s | %s | %s | %s | %s | %s | %s | %s | %s | %s | | | |", r.id, cell(r.title), r.step, verdict, cell(r.worst or ""),
      short(r.value), most, short(r.margin), cell(r.always or ""), short(r.dearest), short(r.ms), r.shares or "")
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

local function figures(list)
  local out, passed, fine = {}, 0, 0
  local function add(format, ...) out[#out + 1] = select("#", ...) > 0 and format:format(...) or format end
  for _, r in ipairs(list) do
    passed, fine = passed + (r.verdict == "pass" and 1 or 0), fine + (r.always == "ok" and 1 or 0)
  end
  add("%d runs (a case at a frame step): %d pass their own criteria; in %d all of G1 to G8 hold.", #list, passed, fine)
  add ""
  write_table(list, add)
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
  io.stderr:write("hard-cases: no rows in ", rows_folder, "\n")
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
