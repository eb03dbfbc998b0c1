-- digbox/film.lua - sun, lamps, sky, cameras, pictures and films.
--
-- A film has a frame at every multiple of 1/fps from the moment it starts to the moment it closes, both included. Frames between
-- two steps are blended between them, so fps never changes the physics.

local core = ...
local next, type = next, type

local methods = core.types.world.methods
local ON_TIME = 1e-9       -- s; nearer than this a frame falls on a step

local LONGEST_NAME = 63    -- bytes; a replay has room for no more

local default_fov = 40 * math.pi / 180
local layers = { colour = 0, depth = 1, id = 2, normal = 3 }
local skies = { clear = 0, overcast = 1, night = 2, black = 3 }
local overlays = {}
for name, bit in next, core.overlays or {} do overlays[name] = bit end

local function scene_of(world) return core.lua_state(world).scene end

-- Replays keep light, cameras and films; they look at them again when these numbers changed.
local function changed(list) list.changes = (list.changes or 0) + 1 end

-- ---- light ----

core.declare("world:sun", { "Where the sun stands.", fields = { from = { "dir 1", "from where it shines" },
  shadows = { "bool", "things cast shadows" } } })

-- world:sun{from = {3, 6, 2}, shadows = true}
function methods.sun(world, fields)
  local f = core.check(fields, "world:sun")
  local scene = scene_of(world)
  scene.sun = f.from or scene.sun
  if f.shadows ~= nil then scene.shadows = f.shadows end
  changed(scene)
end

core.declare("world:lamp", { "A lamp, one of at most four.", fields = { at = { "vec m", "where it hangs", need = true },
  power = { "real W >0", "how bright", default = 60 }, colour = { "colour 1", "of its light" } } })

-- world:lamp{at=, power = "60 W", colour=}
function methods.lamp(world, fields)
  local f = core.check(fields, "world:lamp")
  local lamps = scene_of(world).lamps
  if not f.at then core.fail "world:lamp: at is missing" end
  if #lamps == 4 then core.fail "world:lamp: there are 4 lamps already, more cannot be drawn" end
  lamps[#lamps + 1] = { at = f.at, power = f.power, colour = f.colour }
  changed(scene_of(world))
end

core.declare("world:sky", { "What is behind everything.", takes = { { "name", "text", "which sky", of = skies } } })

-- world:sky "clear" | "overcast" | "night" | "black"
function methods.sky(world, name)
  if type(name) ~= "string" or not skies[name] then core.unknown("world:sky:", "unknown sky", tostring(name), skies) end
  scene_of(world).sky = skies[name]
  changed(scene_of(world))
end

-- ---- cameras ----

local camera_fields = core.declare("world:camera", { "A camera; what it does not say is chosen so that everything is seen.", fields = {
  name = { "text", "its name" }, at = { "vec m", "where it stands" }, look_at = { "any", "a body or a point", type = "body|vector" },
  fov = { "real rad >0", "opening angle; default 40 deg", max = 3 }, up = { "dir 1", "which way is up in the picture" },
  follow = { "body", "it moves with this body" } }, optional = true, gives = "camera" })
core.declare_type("camera", "A camera. Its fields can be read and assigned.", {}, {
  name = { "string|nil", "its name", set = true }, at = { "vector|nil", "where it stands", unit = "m", set = true },
  look_at = { "body|vector|nil", "what it looks at", set = true }, fov = { "number|nil", "opening angle", unit = "rad", set = true },
  up = { "vector|nil", "which way is up", set = true }, follow = { "body|nil", "what it moves with", set = true } })

local function check_camera(fields, what, world)
  local f = core.check(fields, what, camera_fields, world)
  if f.name and #f.name > LONGEST_NAME then core.fail("%s: name has %d bytes, at most %d", what, #f.name, LONGEST_NAME) end
  if f.look_at ~= nil and core.type(f.look_at) ~= "body" then
    f.look_at = core.check({ look_at = f.look_at }, what, { look_at = "vec m" }).look_at
    if f.at and #(f.look_at - f.at) <= 0 then core.fail("%s: at and look_at are the same point %s m", what, tostring(f.at)) end
  end
  return f
end

-- What a camera is inside: fields; world; start, where the body that it follows was.
local Camera = { __name = "camera", __metatable = false }
local make_camera, open_camera, is_camera = core.opaque(Camera)

-- Whether one of the world's cameras may move by itself.
local function cameras_changed(cameras)
  changed(cameras)
  cameras.moving = false
  for _, cam in ipairs(cameras) do
    local f = open_camera(cam).fields
    cameras.moving = cameras.moving or f.follow ~= nil or core.type(f.look_at) == "body"
  end
end

Camera.__index = function(cam, key)
  if not camera_fields[key] then core.unknown("camera", "has no field", tostring(key), camera_fields) end
  return open_camera(cam).fields[key]
end
Camera.__newindex = function(cam, key, value)
  local c = open_camera(cam)
  local checked, f = check_camera({ [key] = value }, "camera", c.world), c.fields
  f[key] = checked[key]
  if key == "follow" or key == "at" then c.start = f.follow and f.follow.position end
  cameras_changed(core.lua_state(c.world).cameras)
end
Camera.__tostring = function(cam) return ("camera '%s'"):format(open_camera(cam).fields.name or "") end

-- world:camera{at=, look_at = body or point, fov = "40 deg", follow = body, up=, name=} -> camera
function methods.camera(world, fields)
  local f = check_camera(fields or {}, "world:camera", world)
  local state = core.lua_state(world)
  local cam = make_camera { fields = f, world = world, start = f.follow and f.follow.position }
  state.cameras = state.cameras or {}
  state.cameras[#state.cameras + 1] = cam
  cameras_changed(state.cameras)
  return cam
end

local function place(target)
  if core.type(target) == "body" then return target.valid and target.centre or nil end
  return target
end

-- {at, look_at, up, fov} from what is said; what is not is chosen so that everything is seen.
function core.resolve_camera(said, view, aspect)
  local fov, target = said.fov or default_fov, said.look_at
  local at, look_at, up = core.view_camera(view, fov, aspect)
  if said.at then
    at = said.at
    look_at = target or look_at
  elseif target then
    at, look_at = at + (target - look_at), target
  end
  if #(look_at - at) <= 0 then core.fail "the camera looks at the point it stands at" end
  return { at = at, look_at = look_at, up = said.up or up, fov = fov }
end

-- Where the camera stands now.
local function resolve(cam, view, aspect)
  local c = cam and open_camera(cam)
  local f = c and c.fields or {}
  local moved = f.at and f.follow and f.follow.valid and f.follow.position - c.start
  local said = { at = f.at and (moved and f.at + moved or f.at), look_at = place(f.look_at) or f.follow and place(f.follow), up = f.up,
    fov = f.fov }
  return core.resolve_camera(said, view, aspect)
end

local function blend_cameras(a, b, s)
  return { at = a.at * (1 - s) + b.at * s, look_at = a.look_at * (1 - s) + b.look_at * s, up = b.up, fov = b.fov }
end

local function default_camera(world)
  local cameras = core.lua_state(world).cameras
  return cameras and cameras[1]
end

-- ---- for replays: the same as plain tables ----

-- Where the script's cameras stand, as far as the script says; nil: it made none. What is not there is chosen by who draws, so
-- that everything is seen: at is then moved along with look_at.
function core.cameras_now(world)
  local cameras = core.lua_state(world).cameras
  if not cameras then return nil end
  local list = {}
  for i, cam in ipairs(cameras) do
    local c = open_camera(cam)
    local f = c.fields
    local target = place(f.look_at) or f.follow and place(f.follow)
    local moved = f.at and f.follow and f.follow.valid and f.follow.position - c.start
    list[i] = { name = f.name or "", at = f.at and (moved and f.at + moved or f.at), look_at = target, up = f.up,
      fov = f.fov or default_fov }
  end
  return list
end

function core.light_now(world)
  local scene = scene_of(world)
  local sky = "clear"
  for name, number in next, skies do
    if number == scene.sky then sky = name end
  end
  return { sun = scene.sun, shadows = scene.shadows, sky = sky, lamps = scene.lamps }
end

-- Films that were ever begun, in their order; nil: none.
function core.films_now(world)
  local list = core.lua_state(world).all_films
  if not list then return nil end
  local out = {}
  for i, film in ipairs(list) do
    local o, camera = film.options, nil
    for k, cam in ipairs(core.lua_state(world).cameras or {}) do
      if cam == (film.camera or default_camera(world)) then camera = k - 1 end
    end
    local names = {}
    for name, bit in next, overlays do
      if o.overlay & bit ~= 0 then names[#names + 1] = name end
    end
    table.sort(names)
    local layer = "colour"
    for name, number in next, layers do
      if number == o.layer then layer = name end
    end
    out[i] = { to = film.path, fps = film.fps, first = film.first, frames = film.closed and film.frames or nil, width = o.width,
      height = o.height, samples = not o.smooth and o.samples or nil, layer = layer, overlay = names, camera = camera }
  end
  return out
end

-- ---- options common to pictures and films ----

local function check_size(size, what)
  local w, h = 1280, 720
  if size ~= nil then
    if type(size) ~= "table" then core.fail("%s.size wants {width, height}; got %s", what, core.type(size)) end
    w, h = size[1], size[2]
  end
  for name, n in next, { width = w or false, height = h or false } do
    local pixels = core.whole(n)
    if not pixels or pixels < 1 or pixels > 16384 then
      core.fail("%s.size: %s = %s, must be a whole number from 1 to 16384", what, name, tostring(n))
    end
  end
  return core.whole(w), core.whole(h)
end

local function check_overlay(list, what)
  local bits = 0
  if type(list) == "string" then list = { list } end
  if list ~= nil and type(list) ~= "table" then core.fail("%s.overlay wants a list of names; got %s", what, core.type(list)) end
  for _, name in ipairs(list or {}) do
    if type(name) ~= "string" or not overlays[name] then core.unknown(what .. ".overlay:", "unknown overlay", tostring(name), overlays) end
    bits = bits | overlays[name]
  end
  return bits
end

-- What pictures of that size take is known before anything is simulated for them. workers: so many processes draw side by side.
function core.check_room(o, what, workers)
  if not core.can_render then return end
  local need, room = core.picture_need(o)
  need = need * (workers or 1)
  if need > room then
    core.fail("%s: a picture of %d x %d pixels%s%s needs about %.1f GiB of memory, here are at most %.1f GiB (--memory-limit, or three " ..
      "quarters of the machine's)", what, o.width, o.height, o.samples > 0 and (" with %d samples each"):format(o.samples) or "",
      workers and workers > 1 and (" by each of %d processes"):format(workers) or "", need / 2 ^ 30, room / 2 ^ 30)
  end
end

function core.drawing_options(f, what, world)
  local o = {}
  o.width, o.height = check_size(f.size, what)
  o.overlay = check_overlay(f.overlay, what)
  o.smooth = f.samples == nil or nil       -- without samples edges are smoothed afterwards, which looks the same
  o.samples = f.samples or 0
  if o.samples ~= 0 and o.samples ~= 2 and o.samples ~= 4 then core.fail("%s: samples = %d, must be 0, 2 or 4", what, o.samples) end
  local layer = f.layer or "colour"
  if not layers[layer] then core.unknown(what .. ":", "unknown layer", layer, layers) end
  o.layer = layers[layer]
  if f.camera ~= nil and not is_camera(f.camera) then core.fail("%s.camera wants a camera; got %s", what, core.type(f.camera)) end
  if f.camera and open_camera(f.camera).world ~= world then core.fail("%s.camera belongs to another world", what) end
  core.check_room(o, what)
  return o
end

-- The options of one frame: size and so on, where the camera is, how the scene is lit.
local function frame_options(o, camera, scene)
  return { width = o.width, height = o.height, samples = o.samples, smooth = o.smooth, layer = o.layer, overlay = o.overlay,
    at = camera.at, look_at = camera.look_at, up = camera.up, fov = camera.fov,
    sun = scene.sun, shadows = scene.shadows, sky = scene.sky, lamps = scene.lamps }
end

local function texts(world, time)
  local options = core.options
  return { "Software", "digbox " .. core.version, "Time", ("%.17g"):format(time), "Step", ("%d"):format(world.steps),
    "Seed", ("%d"):format(core.state(world).seed or 0), "Script", options.script_name or "", "Script-Hash", options.script_hash or "",
    "Renderer", core.renderer() }
end

local drawing_options = core.drawing_options
core.frame_options, core.blend_cameras, core.skies = frame_options, blend_cameras, skies

-- ---- pictures ----

local picture_fields = {
  camera = { "any", "by which it is seen; default the world's first, or one that sees everything", type = "camera" },
  size = { "any", "{width, height} in pixels; default {1280, 720}", type = "integer[]" },
  samples = { "int", "0, 2 or 4 a pixel; not given: edges are smoothed afterwards" },
  layer = { "text", "what the pixels show: depth is 16-bit grey in mm (65535: the sky), id R + 256 G + 65536 B = body.debug.db_id + 1",
    of = layers, default = "colour" },
  overlay = { "any", "what is drawn over it: a name or a list", type = "string|string[]", of = overlays } }
local TO = { "any", "a file in the output folder", type = "string", need = true }
core.declare("world:render", { "Draws one picture; gives the path of its file.", fields = core.join_fields(picture_fields, { to = TO }),
  gives = "string" })

local function check_target(to, what)
  if type(to) ~= "string" then core.fail("%s: to is missing (a file name such as 'out/a.png')", what) end
  return to
end

-- ---- what was before: trails and energies ----

local function shows_past(o) return o.overlay & ((overlays.trails or 0) | (overlays.energy or 0)) ~= 0 end

-- The step at or before a film's first frame: what was before that its overlays do not show.
function core.first_step_of(first, fps, step) return math.floor(first / fps / step + 1e-6) end

-- Kept from the first film on that shows it.
local function keep_past(film)
  local world, state = film.world, core.lua_state(film.world)
  local first = core.first_step_of(film.first, film.fps, world.frame)
  if state.past and state.past_first <= math.max(first, world.steps) then return end
  state.past, state.past_first = core.past(first, world.frame), first
  core.quiet(world)
end

-- As it is now; nil when it is not asked for.
local function past_of(o, world)
  if not shows_past(o) then return nil end
  local past = core.lua_state(world).past
  core.past_take(past, world)
  return past
end

-- world:render{camera=, to = "out/a.png", size = {w, h}, samples=, layer=, overlay=} -> path
function methods.render(world, fields)
  local f = core.check(fields, "world:render")
  local o = drawing_options(f, "world:render", world)
  if shows_past(o) and not core.lua_state(world).past then
    core.fail "world:render.overlay: trails and energy need what was before: begin a film with that overlay first (world:record)"
  end
  local to = check_target(f.to, "world:render")
  if not to:match "%.png$" then core.fail("world:render: '%s' must end in .png", to) end
  local path = core.out_path(to)
  local view = core.view(world)
  local camera = resolve(f.camera or default_camera(world), view, o.width / o.height)
  local options = frame_options(o, camera, scene_of(world))
  options.past = past_of(o, world)
  core.picture(view, options, path, texts(world, world.time))
  core.lua_state(world).recorded = true
  return path
end

-- ---- films ----

local Film = { __name = "film", __metatable = false }
local make_film, open_film = core.opaque(Film)
local film_methods = {}
local film_readable = core.declare_type("film", "A film that is being taken.", film_methods, {
  frames = { "integer", "frames so far" }, fps = { "number", "frames a second", unit = "Hz" }, path = { "string", "as given" },
  closed = { "boolean", "it has ended" } })
core.declare("film:close", { "Takes the last frame and ends the file." })
Film.__index = function(film, key)
  if film_methods[key] then return film_methods[key] end
  if film_readable[key] then return open_film(film)[key] end
  core.unknown("film", "has no field or method", tostring(key), film_methods, film_readable)
end
Film.__newindex = function(_, key) core.fail("film.%s cannot be assigned", tostring(key)) end
Film.__tostring = function(film) return ("film '%s', %d frames"):format(open_film(film).path, open_film(film).frames) end

core.declare("world:record", { "Takes a film: frames at exact multiples of 1/fps while the world runs.",
  fields = core.join_fields(picture_fields, { to = TO, fps = { "real Hz >0", "frames a second", default = 30, max = 1e5 } }),
    gives = "film" })

local function open_video(film, to)
  local path, options = core.out_path(to), core.options
  if options.mode == "run" and not options.force and not options.resume and core.exists(path) then
    core.usage("%s: a film is there; --force takes it anew", path)
  end
  core.sweep(path)
  local pipe = not options.dry and core.pipe(path, film.options.width, film.options.height, film.fps)
  if pipe then
    film.pipe = pipe
    return
  end
  if options.dry then return end
  film.pattern = to:gsub("%.%w+$", "-%%05d.png")
  core.tell(("digbox: no ffmpeg here: writing %s; later: ffmpeg -r %g -i %s %s\n"):format(film.pattern, film.fps, film.pattern, to))
end

-- world:record{camera=, to = "out/f-%05d.png" | "out/f.mp4" | "out/f.webm", fps = 30, size=, overlay=} -> film
function methods.record(world, fields)
  local f = core.check(fields, "world:record")
  local to = check_target(f.to, "world:record")
  local fps = f.fps
  local film = { fps = fps, frames = 0, path = to, closed = false, world = world, camera = f.camera,
    options = drawing_options(f, "world:record", world) }
  -- The first frame: at the first multiple of 1/fps that is not past.
  film.first = math.ceil(world.time * fps - ON_TIME * fps)
  if to:match "%.png$" then
    film.pattern = to
    if not core.frame_path(to, 0) then core.fail("world:record: '%s' needs a place for the number: 'out/f-%%05d.png'", to) end
    core.out_path(core.frame_path(to, 0))
  elseif to:match "%.mp4$" or to:match "%.webm$" then
    if film.options.layer ~= 0 and film.options.layer ~= 3 then
      core.fail "world:record: a video holds the layers colour and normal; write depth and id as PNG"
    end
    open_video(film, to)
  else
    core.fail("world:record: '%s' must end in .png, .mp4 or .webm", to)
  end
  if film.pattern then core.begin_frames(film) end
  if shows_past(film.options) then keep_past(film) end
  local state = core.lua_state(world)
  state.films[#state.films + 1] = film
  core.quiet(world)
  state.all_films = state.all_films or {}
  state.all_films[#state.all_films + 1] = film
  changed(state.all_films)
  state.recorded = true
  core.open_films = core.open_films or {}
  core.open_films[film] = true
  return make_film(film)
end

local function next_time(film) return (film.first + film.frames) / film.fps end

local function take(film, view, camera, time)
  local o = frame_options(film.options, camera, scene_of(film.world))
  if shows_past(film.options) then o.past = core.lua_state(film.world).past end
  if film.pipe then
    film.pipe:frame(view, o)
  else
    core.put_frame(film, film.frames, view, o, texts(film.world, time), time)
  end
  film.frames = film.frames + 1
  core.frames = (core.frames or 0) + 1
end

local function camera_of(film, view)
  return resolve(film.camera or default_camera(film.world), view, film.options.width / film.options.height)
end

-- Frames that fall on the present time.
local function take_present(film, view)
  local now = film.world.time
  while next_time(film) <= now + ON_TIME do
    view = view or core.view(film.world)
    take(film, view, camera_of(film, view), now)
  end
  return view
end

-- Before a step: frames of this moment; keeps a view when a frame falls inside the step.
function core.film_before_step(world, state)
  local view
  local after = world.time + world.frame
  state.view_before = nil
  if state.past then core.past_take(state.past, world) end
  for _, film in ipairs(state.films) do
    view = take_present(film, view)
    if next_time(film) < after - ON_TIME then
      view = view or core.view(world)
      state.view_before = view
      film.camera_before = camera_of(film, view)
    end
  end
end

-- Frames strictly inside a step, after it.
local function take_inside(world, state, before)
  local view, now, dt = core.view(world), world.time, world.frame
  for _, film in ipairs(state.films) do
    if film.camera_before then
      local camera = camera_of(film, view)
      while next_time(film) < now - ON_TIME do
        local s = (next_time(film) - (now - dt)) / dt
        core.blend(before, view, s)
        take(film, view, blend_cameras(film.camera_before, camera, s), next_time(film))
      end
      film.camera_before = nil
    end
  end
  state.view_before = nil
end

-- After a step; what was before a frame inside it does not have the step's end.
function core.film_after_step(world, state)
  if state.view_before then take_inside(world, state, state.view_before) end
  if state.past then core.past_energy(state.past, world) end
end

-- Takes no further frame.
local function take_out(film)
  film.closed = true
  core.open_films[film] = nil
  local state = core.lua_state(film.world)
  changed(state.all_films)
  for i, f in ipairs(state.films) do
    if f == film then
      table.remove(state.films, i)
      break
    end
  end
end

local function close_film(film)
  if film.closed then return end
  take_out(film)
  if not core.stopping then
    local past = core.lua_state(film.world).past
    if past then core.past_take(past, film.world) end
    take_present(film)
  end
  if film.pipe then film.pipe:close() end
  core.end_frames(film, not core.stopping)
end

-- After a frame that could not be written
function core.drop_film(film)
  take_out(film)
  core.end_frames(film, false)
end

-- film:close(): the last frame, and the end of the file
function film_methods.close(film)
  close_film(open_film(film))
end

-- core.close_films([world]): all that are open
function core.close_films(world)
  local list = {}
  for film in next, core.open_films or {} do
    if not world or film.world == world then list[#list + 1] = film end
  end
  table.sort(list, function(a, b) return a.path < b.path end)
  for _, film in ipairs(list) do close_film(film) end
end

-- The picture of the end state, for a run that recorded nothing. Returns its path or nil.
function core.final_picture(name)
  local world = core.last_world
  if not (core.can_render and world and core.is_open(world)) or core.lua_state(world).recorded then return nil end
  return methods.render(world, { to = name .. ".png" })
end

return true
