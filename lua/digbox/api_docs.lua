-- digbox/api_docs.lua - the interface on paper: docs/lua.md, the manual page, the completion of bash.

local core = ...
local next, ipairs = next, ipairs

local api = core.api
local sorted = api.sorted
local writers = {}

-- ---- docs/lua.md ----

local function cell(text) return (text:gsub("|", "\\|")) end

local function table_of(lines, head, rows)
  if #rows == 0 then return end
  lines[#lines + 1] = "| " .. table.concat(head, " | ") .. " |"
  lines[#lines + 1] = "|" .. ("---|"):rep(#head)
  for _, row in ipairs(rows) do
    for i, text in ipairs(row) do row[i] = cell(text) end
    lines[#lines + 1] = "| " .. table.concat(row, " | ") .. " |"
  end
  lines[#lines + 1] = ""
end

local function field_rows(fields, prefix, rows)
  for _, name in ipairs(sorted(fields)) do
    local f = fields[name]
    rows[#rows + 1] = { "`" .. prefix .. name .. "`", api.type_text(f), api.default(f), api.help(f) .. (f.effect
      and " (effect " .. f.effect .. ")" or "") }
    if f.fields then field_rows(f.fields, prefix .. name .. ".", rows) end
  end
  return rows
end

local heads = { "field", "type", "default", "what it is" }

local function set_link(name)
  return ("[%s](#fields-of-%s)"):format(name, (("fields of " .. name):lower():gsub("fields of ", ""):gsub(" ", "-")))
end

local function call_section(lines, e)
  lines[#lines + 1] = ("#### `%s`"):format(api.call(e)) .. (e.gives and " -> " .. cell(e.gives) or "")
  lines[#lines + 1] = ""
  lines[#lines + 1] = e[1] or ""
  local links = {}
  for i, name in ipairs(e.with or {}) do links[i] = set_link(name) end
  if #links > 0 then lines[#lines] = lines[#lines] .. " Fields of " .. table.concat(links, " and ") .. (next(e.fields or {}) and ", and:"
    or ".") end
  lines[#lines + 1] = ""
  local rows = {}
  for _, a in ipairs(e.takes or {}) do
    local f = { a[2], a[3], type = a.type, of = a.of, default = a.default, need = not a.optional }
    rows[#rows + 1] = { "(" .. a[1] .. ")", api.type_text(f), api.default(f), api.help(f) }
  end
  table_of(lines, heads, field_rows(e.fields or {}, "", rows))
  for _, other in ipairs(e.also or {}) do
    other.name, other.gives, other[1] = e.name, e.gives, "The same, called in another way."
    call_section(lines, other)
  end
end

local function owner_section(lines, owner)
  local t = core.declared.types[owner]
  lines[#lines + 1] = "## " .. owner
  lines[#lines + 1] = ""
  local intro = { digbox = 'The module: `local digbox = require "digbox"`.',
    parts = 'Ready-made parts, in `digbox.parts`: `digbox.parts.door(world, { at = { 0, 0, 0 } })`. A part is found by its name, too.',
    test = 'The scenario kit: `local test = require "digbox.test"`.' }
  lines[#lines + 1] = t and t.help or intro[owner]
  lines[#lines + 1] = ""
  local rows = {}
  for _, name in ipairs(t and sorted(t.properties) or {}) do
    local p = t.properties[name]
    rows[#rows + 1] = { "`" .. owner .. "." .. name .. "`", p[1] .. (p.unit and ", " .. p.unit or "") .. (p.set and ", assignable" or ""),
      p[2] }
  end
  table_of(lines, { "property", "type", "what it is" }, rows)
  for _, e in ipairs(api.entries) do
    if e.owner == owner then call_section(lines, e) end
  end
end

local function list_of_sets()
  local used, list = {}, {}
  for _, e in ipairs(api.entries) do
    for _, name in ipairs(e.with or {}) do used[name] = true end
  end
  for _, name in ipairs(sorted(api.sets)) do
    if used[name] then list[#list + 1] = api.sets[name] end
  end
  return list
end

function writers.markdown()
  local lines = { "# The Lua interface", "",
    "Written by `make docs` from the declarations in the program; `digbox api NAME` prints the same, `digbox api --luacats` gives",
    "it to an editor. SI units, radians, y up. A number is SI; a text carries its unit (`\"4 cm\"`) and must have the right",
    "dimension. Where a vector is wanted, `{x, y, z}` does. Fields that are not listed are refused, with the name that was meant.", "" }
  local links = {}
  for _, owner in ipairs(api.owners) do links[#links + 1] = ("[%s](#%s)"):format(owner, owner:lower()) end
  lines[#lines + 1] = table.concat(links, " · ") .. " · [events](#events) · [sets of fields](#sets-of-fields)"
  lines[#lines + 1] = ""
  for _, owner in ipairs(api.owners) do owner_section(lines, owner) end
  lines[#lines + 1] = "## events"
  lines[#lines + 1] = ""
  lines[#lines + 1] = "For `world:on` and `body:on`; delivered after the step, in the order of time, kind and lower number."
  lines[#lines + 1] = ""
  local rows = {}
  for i, e in ipairs(api.events) do rows[i] = { "`" .. e.name .. "`", e.help, table.concat(e.fields, " ") } end
  table_of(lines, { "event", "when", "its fields" }, rows)
  lines[#lines + 1] = "## sets of fields"
  lines[#lines + 1] = ""
  for _, set in ipairs(list_of_sets()) do
    lines[#lines + 1] = "### fields of " .. set.name
    lines[#lines + 1] = ""
    lines[#lines + 1] = set.help:sub(1, 1):upper() .. set.help:sub(2) .. (set.help:sub(-1) == "." and "" or ".")
    lines[#lines + 1] = ""
    table_of(lines, heads, field_rows(set.fields, "", {}))
  end
  if lines[#lines] == "" then lines[#lines] = nil end
  return table.concat(lines, "\n") .. "\n"
end

-- ---- commands: their options are read from their help ----

-- {{long =, short =, value =, help =}, ...}
local function options_of(command)
  local list = {}
  for line in ((command.options or "") .. "\n"):gmatch "(.-)\n" do
    local words, help = line:match "^%s+(%-.-)%s%s+(.+)$"
    words = words or line:match "^%s+(%-%S.*)$"
    if words then
      local o = { help = help or "", words = words }
      for word in words:gmatch "%-%-?[%w%-]+" do
        if word:find "^%-%-" then o.long = o.long or word else o.short = o.short or word end
      end
      o.value = words:match "[%s=]([A-Z]%S*)$"
      if o.long or o.short then list[#list + 1] = o end
    end
  end
  return list
end

function writers.completion()
  local names, cases = {}, {}
  for i, c in ipairs(core.commands) do
    names[i] = c.name
    local words = {}
    for _, o in ipairs(options_of(c)) do
      words[#words + 1] = o.long
      words[#words + 1] = o.short
    end
    words[#words + 1] = "--help"
    cases[i] = ("        %s) options='%s' ;;"):format(c.name, table.concat(words, " "))
  end
  local dotted = {}
  for i, name in ipairs(api.names()) do dotted[i] = name end
  for _, t in ipairs(api.types) do dotted[#dotted + 1] = t.name end
  return ([[
# bash completion of digbox, written by `digbox api --completion bash`.
# shellcheck shell=bash
# Source it, or put it into ~/.local/share/bash-completion/completions/digbox
_digbox() {
    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} command=${COMP_WORDS[1]} options=''
    COMPREPLY=()
    if [ "$COMP_CWORD" -eq 1 ]; then
        mapfile -t COMPREPLY < <(compgen -W '@COMMANDS@ --help --version' -- "$word")
        return
    fi
    case $before in
        --accuracy) mapfile -t COMPREPLY < <(compgen -W 'sketch play study reference' -- "$word"); return ;;
        --completion) mapfile -t COMPREPLY < <(compgen -W 'bash' -- "$word"); return ;;
    esac
    case $command in
@CASES@
    esac
    if [ "$command" = api ] && [ "${word#-}" = "$word" ]; then
        local names='@NAMES@'
        # bash takes a colon for the end of a word: complete what comes after it
        local line=${COMP_LINE:0:COMP_POINT}
        local typed=${line##* }
        mapfile -t COMPREPLY < <(compgen -W "$names" -- "$typed")
        case $typed in *:*) COMPREPLY=("${COMPREPLY[@]#"${typed%:*}:"}") ;; esac
        return
    fi
    if [ "${word#-}" != "$word" ]; then
        mapfile -t COMPREPLY < <(compgen -W "$options" -- "$word")
    else
        mapfile -t COMPREPLY < <(compgen -f -X '!*.lua' -- "$word"; compgen -d -- "$word")
    fi
}
complete -o filenames -F _digbox digbox
]]):gsub("@(%u+)@", { COMMANDS = table.concat(names, " "), CASES = table.concat(cases, "\n"), NAMES = table.concat(dotted, " ") })
end

-- ---- the manual page ----

local function roff(text) return (text:gsub("\\", "\\e"):gsub("%-", "\\-"):gsub("^([.'])", "\\&%1"):gsub("\n([.'])", "\n\\&%1")) end

local files = {
  { "docs/lua.md", "every function, with its fields" }, { "worlds/", "worlds to begin with, installed below share/doc/digbox" } }
local variables = {
  { "GALLIUM_DRIVER", "the driver that draws: llvmpipe or softpipe" }, { "LP_NUM_THREADS", "how many threads draw" },
  { "NO_COLOR", "no line of progress" } }

function writers.man()
  local lines = { '.TH DIGBOX 1 "" "digbox ' .. core.version .. '" "User Commands"', ".SH NAME",
    "digbox \\- a 3D physics sandbox with dynamic interaction graphs", ".SH SYNOPSIS" }
  for _, c in ipairs(core.commands) do
    lines[#lines + 1] = ".B digbox " .. roff(c.name)
    lines[#lines + 1] = roff((c.use:match("digbox " .. c.name .. "%s*(.-)%s%s") or ""))
    lines[#lines + 1] = ".br"
  end
  lines[#lines] = ".SH DESCRIPTION"
  lines[#lines + 1] = roff("Runs worlds and scenarios written in Lua. Units are SI, y is up. " ..
    "Errors go to stderr as digbox: FILE:LINE: message.")
  lines[#lines + 1] = ".SH COMMANDS"
  for _, c in ipairs(core.commands) do
    lines[#lines + 1] = ".SS " .. roff(c.name)
    lines[#lines + 1] = roff((c.use:gsub("^%s+", ""):gsub("%s*\n%s*", " "):gsub("%s%s+", ": ", 1):gsub("%s+$", "")))
    for _, o in ipairs(options_of(c)) do
      lines[#lines + 1] = ".TP\n.B " .. roff(o.words)
      lines[#lines + 1] = roff(o.help)
    end
  end
  lines[#lines + 1] = ".SH LUA INTERFACE"
  lines[#lines + 1] = roff "digbox api NAME says more of each of these."
  local texts = {}
  for _, e in ipairs(api.entries) do texts[e.name] = e[1] end
  for _, e in ipairs(api.events) do texts[e.name] = "Event. " .. e.help end
  for name, f in next, api.sets.body.fields do texts["body." .. name] = f[2] end
  for _, t in ipairs(api.types) do
    for name, p in next, t.properties do texts[t.name .. "." .. name] = p[2] end
  end
  for _, name in ipairs(api.names()) do lines[#lines + 1] = ".TP\n.B " .. roff(name) .. "\n" .. roff(texts[name]) end
  for _, part in ipairs { { "ENVIRONMENT", variables }, { "FILES", files } } do
    lines[#lines + 1] = ".SH " .. part[1]
    for _, row in ipairs(part[2]) do lines[#lines + 1] = ".TP\n.B " .. roff(row[1]) .. "\n" .. roff(row[2]) end
  end
  lines[#lines + 1] = ".SH EXIT STATUS"
  lines[#lines + 1] = roff(core.exit_codes)
  return table.concat(lines, "\n") .. "\n"
end

-- ---- docs/materials.md ----

local columns = api.material_columns

local function figure(x) return x and ("%.6g"):format(x) or "" end

function writers.materials()
  local world = core.digbox.world {}
  local head, units, rows = { "material" }, { "" }, {}
  for i, c in ipairs(columns) do head[i + 1], units[i + 1] = c[1], c[2] ~= "1" and c[2] or "" end
  rows[1] = units
  for _, name in ipairs(core.material_names(world)) do
    local m, row = core.material_of(world, name), { "`" .. name .. "`" }
    for i, c in ipairs(columns) do row[i + 1] = figure(m[c[1]]) end
    rows[#rows + 1] = row
  end
  local lines = { "# Materials", "",
    "Written by `make docs` from the table in `engine/world/material.c`. `material = \"steel\"` gives a body all of a row;",
    "`body.material = \"oak\"` changes all of it: the mass with the density, and what the body was not given itself (`friction`,",
    "`heat_capacity`, ...). `digbox.material(name, {...})` adds one.", "" }
  table_of(lines, head, rows)
  lines[#lines + 1] = "## Pairs"
  lines[#lines + 1] = ""
  lines[#lines + 1] = "Two materials without a row here take the geometric mean of their frictions and the larger restitution."
  lines[#lines + 1] = "`digbox.material_pair{...}` adds one."
  lines[#lines + 1] = ""
  rows = {}
  for i, p in ipairs(core.material_pairs(world)) do
    rows[i] = { "`" .. p.a .. "`", "`" .. p.b .. "`", figure(p.friction), figure(p.friction_dynamic), figure(p.restitution) }
  end
  table_of(lines, { "one", "the other", "friction", "friction_dynamic", "restitution" }, rows)
  for _, line in ipairs { "## Where the figures are from", "",
    "* Densities, heat capacities, conductivities, resistivities: CRC Handbook (`crc2016` in `docs/references.bib`).",
    "* Strengths, and friction of pairs: Machinery's Handbook (`oberg2012`).",
    "* Young's moduli: CRC Handbook; of woods, along the grain and bent: Wood Handbook, ch. 5 (`woodhandbook2010`); of cork, felt, foam,",
    "  leather and paper: Ashby, app. A, the middle of the range (`ashby2011`).",
    "* Friction of a material alone is meant against the like of it; restitutions and rolling frictions are typical values,",
    "  since they depend on speed and shape as much as on the material." } do lines[#lines + 1] = line end
  world:close()
  return table.concat(lines, "\n") .. "\n"
end

function writers.names() return table.concat(api.names(), "\n") .. "\n" end

return writers
