-- .luacheckrc - luacheck: Lua 5.4, no globals. In specs `digbox` is there without require.
std = "lua54"
max_line_length = 140
files["**/*_spec.lua"] = { read_globals = { "digbox" } }
files["tests/scenarios/*.lua"] = { read_globals = { "digbox" } }
