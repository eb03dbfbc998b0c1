-- tests/hard/peers/judge.lua - the verdict on what another engine made of a hard case: the case's own criteria, less those on what only
-- digbox tells, and a state that is lost fails.
local untold = {
  ["conflict shown in the figures"] = {}, ["events more or less"] = {}, ["energy not accounted for / work"] = {},
  ["force of a hinge / weight"] = { mujoco = true },
}

local function told(criterion, engine)
  local by = untold[criterion.name]
  return not by or next(by) ~= nil and not by[engine]
end

-- hard.run's row; returns pass, fail, over time or none (nothing is left to judge)
return function(hard, row, engine)
  local list = {}
  for _, c in ipairs(row.criteria) do
    if told(c, engine) then list[#list + 1] = c end
  end
  if #list == 0 then return "none" end
  for _, c in ipairs(row.always) do
    if c.name:sub(1, 2) == "G1" and not c.pass then list[#list + 1] = c end
  end
  row.criteria, row.broke = list, nil
  hard.judge(row)
  return row.pass and "pass" or row.over_time and not row.broke and "over time" or "fail"
end
