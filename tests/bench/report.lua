-- tests/bench/report.lua - from the rows of measure.sh: a JSON file, and a table with ratios to Bullet and the goals.
--
--   lua5.4 tests/bench/report.lua build/bench/rows.lua build/bench.json
--
-- A figure is the median (or 99th percentile) over the last two thirds of the steps, and of several runs the least, which other
-- work on the machine has disturbed the least: processor time with one thread, wall clock with more. Ratios compare the same
-- clock, over the steps that both have made when a time limit cut one short. What the checker
-- finds wrong (bodies lost, deep overlaps, joints apart, towers fallen) has no ratio.

local source, target = arg[1], arg[2]
local rows, results = {}, {}

-- What is asked of digbox: most of Bullet's time, and of overlap and joint error (mm); box3d is the ratio of that engine.
local goals = {
    ["pyramid 30"] = {ratio = 0.33, box3d = 0.41, penetration = 5.3, height = 29.3},
    ["towers 1000"] = {ratio = 0.33, box3d = 0.41, penetration = 5, height = 9.4, speedup = 1.8},
    ["chains 100"] = {ratio = 0.45, box3d = 0.79, joint = 1},
    ["pile_mixed 4000"] = {ratio = 0.19, box3d = 0.24, penetration = 41, speedup = 1.8},
    ["pile_spheres 8000"] = {ratio = 0.34, box3d = 0.43, penetration = 45, speedup = 1.8},
    ["sleeping 50000"] = {ratio = 1 / 2000, box3d = 1 / 1300},
}
local wrong_mm <const>, wrong_joint_mm <const> = 450, 500      -- nearer to a lost body than to a soft contact
local busy <const> = 1.2       -- wall clock over processor time of one thread: above it, others work here too, and two threads tell nothing
local phases <const> = {"us_sense", "us_touch", "us_graph", "us_advance", "us_commit", "us_report"}
local engines <const> = {digbox = 1, bullet = 2, ode = 3, mujoco = 4}

local function quantile(list, part)
    local sorted = table.move(list, 1, #list, 1, {})
    table.sort(sorted)
    return sorted[math.max(1, math.ceil(part * #sorted))]
end

-- Of the steps after the first third of `steps`.
local function window(clock, steps)
    local list = {}
    for i = steps // 3 + 1, math.min(steps, #clock) do list[#list + 1] = clock[i] end
    return list
end

local function clock_of(row) return row.threads > 1 and "wall" or "cpu" end

local function key(scene, n, engine, threads) return table.concat({scene, n, engine, threads}, " ") end

local function read()
    local place = {row = function(r) rows[#rows + 1] = r end}
    assert(loadfile(source, "t", place))()
end

-- One result of the rows of all repeats; a run that was cut is taken as far as it went.
local function collect()
    local by_key = {}
    for order, row in ipairs(rows) do
        local k = key(row.scene, row.n, row.engine, row.threads)
        local result = by_key[k]
        if not result then
            result = {row = row, runs = {}, order = order, name = row.scene .. " " .. row.n}
            by_key[k] = result
            results[#results + 1] = result
        end
        result.runs[#result.runs + 1] = row
    end
    return by_key
end

-- The least, over the runs, of a quantile over `steps` steps; nil when nothing ran.
local function time(result, clock, steps, part)
    local best
    for _, run in ipairs(result.runs) do
        local ms = window(run[clock], steps or run.steps)
        if #ms > 0 then best = math.min(best or math.huge, quantile(ms, part or 0.5)) end
    end
    return best
end

local function wrong(result)
    local row = result.row
    local goal = goals[result.name]
    if row.failed then return row.failed end
    if row.lost > 0 then return row.lost .. " bodies lost" end
    if row.penetration_max_mm > wrong_mm then return "overlap" end
    if row.joint_error_mm > wrong_joint_mm then return "joints apart" end
    if goal and goal.height and row.top_height_m < goal.height then return "fallen" end
end

local function ratio(result, peer)
    if not peer or wrong(result) or wrong(peer) then return end
    local steps, clock = math.min(result.row.steps, peer.row.steps), clock_of(result.row)
    local mine, theirs = time(result, clock, steps), time(peer, clock, steps)
    return mine and theirs and mine / theirs
end

local function derive(by_key)
    for _, r in ipairs(results) do
        local row = r.row
        r.wrong = wrong(r)
        r.median, r.p99 = time(r, clock_of(row)), time(r, clock_of(row), nil, 0.99)
        r.ratio = ratio(r, by_key[key(row.scene, row.n, "bullet", 1)])
        local one = by_key[key(row.scene, row.n, row.engine, 1)]
        if row.threads > 1 and one then
            local times = ratio(r, one)
            local wall, cpu = time(one, "wall"), time(one, "cpu")
            r.busy = wall and wall > busy * cpu
            r.speedup = times and not r.busy and 1 / times or nil
            if row.checksum and row.steps == one.row.steps then r.same_bits = row.checksum == one.row.checksum end
        end
    end
end

local function json_value(v)
    if type(v) == "string" then return '"' .. v:gsub('[%c"\\]', " ") .. '"' end
    if type(v) == "number" and (v ~= v or v == math.huge or v == -math.huge) then return "null" end
    if math.type(v) == "float" then return ("%.6g"):format(v) end
    return tostring(v)
end

local measured <const> = {
    "rss_mb", "penetration_max_mm", "penetration_mean_mm", "top_height_m", "joint_error_mm", "lost", "moving", "steps", "steps_wanted",
    "create_ms", "awake_before", "warm_ms", "us_sense", "us_touch", "us_graph", "us_advance", "us_commit", "us_report", "contacts",
    "points", "pairs", "groups", "sweeps", "sweeps_most", "substeps", "traced", "conserved", "swept", "awake", "world_mb", "allocations",
    "checksum",
}

local function write_json()
    local file = assert(io.open(target, "w"))
    file:write("[\n")
    for i, r in ipairs(results) do
        local fields = {}
        local function put(name, value)
            if value ~= nil then fields[#fields + 1] = ('"%s": %s'):format(name, json_value(value)) end
        end
        for _, name in ipairs {"scene", "n", "engine", "threads"} do put(name, r.row[name]) end
        put("ms_median", r.median)
        put("ms_p99", r.p99)
        put("runs", #r.runs)
        for _, name in ipairs(measured) do put(name, r.row[name]) end
        put("ratio_to_bullet", r.ratio)
        put("speedup", r.speedup)
        put("same_bits", r.same_bits)
        put("wrong", r.wrong)
        file:write("  {", table.concat(fields, ", "), i < #results and "},\n" or "}\n")
    end
    file:write("]\n")
    file:close()
end

local function show(format, value) return value and format:format(value) or "-" end

local function significant(value)
    if not value then return "-" end
    return value >= 100 and ("%.0f"):format(value) or ("%.3g"):format(value)
end

local function print_table()
    local line <const> = "%-20s %-7s %2s %9s %9s %9s %8s %9s %9s %9s %8s  %s"
    print(line:format("scene", "engine", "th", "ms median", "ms p99", "/ bullet", "rss MB", "pen max", "pen mean", "top m", "joint mm", ""))
    local last
    for _, r in ipairs(results) do
        local row, notes = r.row, {}
        if last and last ~= r.name .. row.threads then print() end
        last = r.name .. row.threads
        if r.wrong then notes[#notes + 1] = "WRONG: " .. r.wrong end
        if row.steps_wanted and row.steps < row.steps_wanted then
            notes[#notes + 1] = ("cut at step %d of %d"):format(row.steps, row.steps_wanted)
        end
        if r.speedup then notes[#notes + 1] = ("%.2f x as fast as one thread"):format(r.speedup) end
        if r.busy then notes[#notes + 1] = "busy machine: no speed-up to be seen" end
        if r.same_bits ~= nil then notes[#notes + 1] = r.same_bits and "same bits" or "OTHER BITS" end
        if (row.awake_before or 0) > 0 then notes[#notes + 1] = row.awake_before .. " did not fall asleep" end
        print(line:format(r.name, row.engine, row.threads, significant(r.median), significant(r.p99), significant(r.ratio),
            show("%.0f", row.rss_mb), significant(row.penetration_max_mm), significant(row.penetration_mean_mm),
            show("%.3f", row.top_height_m), significant(row.joint_error_mm), table.concat(notes, ", ")))
    end
end

local function print_phases()
    local head = false
    for _, r in ipairs(results) do
        local row = r.row
        if row.us_sense then
            if not head then
                print("\ndigbox, microseconds of processor time of a phase (median of the timed steps of the first run)")
                print(("%-20s %2s %9s %9s %9s %9s %9s %9s  %8s %8s %7s %6s %7s %9s"):format("scene", "th", "sense", "touch", "graph",
                    "advance", "commit", "report", "contacts", "pairs", "groups", "swept", "sweeps", "allocs"))
                head = true
            end
            local us = {}
            for i, name in ipairs(phases) do us[i] = ("%9.0f"):format(row[name]) end
            print(("%-20s %2d %s  %8d %8d %7d %6d %7d %9d"):format(r.name, row.threads, table.concat(us, " "), row.contacts, row.pairs,
                row.groups, row.swept, row.sweeps, row.allocations))
        end
    end
end

local failed, unknown = 0, 0

-- A row of the list of goals. whole = false: of a run that was cut short or went wrong, which can miss a goal but not meet it.
local function judge(text, value, goal, format, whole, at_least)
    local met = value and (at_least and value >= goal or not at_least and value <= goal)
    local verdict = met and "met" or value and "NOT MET" or "not measured"
    if met and whole == false then verdict, value = "not measured", nil end
    if verdict == "NOT MET" then failed = failed + 1 end
    if verdict == "not measured" then unknown = unknown + 1 end
    print(("  %-12s %-52s %10s   goal %s %s"):format(verdict, text, value and format:format(value) or "-",
        at_least and "at least" or "at most", format:format(goal)))
end

local function per_body(by_key, n)
    local r = by_key[key("pile_spheres", n, "digbox", 1)]
    return r and not r.wrong and r.row.steps == r.row.steps_wanted and r.median / n or nil
end

local function print_goals(by_key)
    local digbox = false
    for _, r in ipairs(results) do digbox = digbox or r.row.engine == "digbox" end
    if not digbox then return end
    print("\nGoals of digbox (a run that was cut short or went wrong meets none)")
    for _, name in ipairs {"pyramid 30", "towers 1000", "chains 100", "pile_mixed 4000", "pile_spheres 8000", "sleeping 50000"} do
        local goal = goals[name]
        local r = by_key[name .. " digbox 1"]
        local many = by_key[name .. " digbox 2"]
        if r then
            local whole = not r.wrong and r.row.steps == r.row.steps_wanted
            local sound = r.row.steps > 0 and r.row.penetration_max_mm <= (goal.penetration or math.huge) and
                r.row.joint_error_mm <= (goal.joint or math.huge)      -- what is fast but wrong is not fast
            judge(("%s: time / Bullet (Box3D %.2g)"):format(name, goal.box3d), r.ratio, goal.ratio, "%.4f", whole and sound)
            local function worst(what, value, most)
                if most then judge(("%s: largest %s, mm"):format(name, what), whole and value or nil, most, "%.3f") end
            end
            worst("overlap", r.row.penetration_max_mm, goal.penetration)
            worst("joint error", r.row.joint_error_mm, goal.joint)
            if goal.speedup then judge(name .. ": two threads over one", many and many.speedup, goal.speedup, "%.2f", nil, true) end
        end
    end
    local scenes = {}
    for _, r in ipairs(results) do scenes[#scenes + 1] = r.name ~= results[1].name and r.name or nil end
    if #scenes == 0 then return end
    local small, large = per_body(by_key, 1000), per_body(by_key, 16000)
    judge("pile_spheres: cost of a body, 16,000 over 1000", small and large and large / small, 2, "%.2f")
    for _, n in ipairs {8000, 16000} do
        local r = by_key[key("pile_spheres", n, "digbox", 1)]
        if r and r.row.rss_mb then judge(("pile_spheres %d: kB of a body"):format(n), r.row.rss_mb * 1024 / n, 4, "%.2f") end
    end
    local steady = by_key["pile_spheres 1000 digbox 1"]
    judge("pile_spheres 1000: allocations in the last 200 steps", steady and steady.row.allocations, 0, "%d")
    local few, many = by_key["large_world 20000 digbox 1"], by_key["large_world 1000000 digbox 1"]
    judge("large_world: 1,000,000 fixed over 20,000", few and many and few.median and many.median and many.median / few.median, 1.1, "%.2f")
    local room = by_key["room 100000 digbox 1"]
    judge("room: bodies lost of 100,000", room and (room.row.lost or 100000), 0, "%d")
    print(("  %d not met, %d not measured"):format(failed, unknown))
end

read()
local by_key = collect()
derive(by_key)
table.sort(results, function(a, b)
    local x, y = a.row, b.row
    if x.threads ~= y.threads then return x.threads < y.threads end
    if a.name ~= b.name then
        local first_a, first_b = math.huge, math.huge
        for _, r in ipairs(results) do
            if r.name == a.name and r.row.threads == x.threads then first_a = math.min(first_a, r.order) end
            if r.name == b.name and r.row.threads == y.threads then first_b = math.min(first_b, r.order) end
        end
        return first_a < first_b
    end
    return engines[x.engine] < engines[y.engine]
end)
write_json()
print_table()
print_phases()
print_goals(by_key)
