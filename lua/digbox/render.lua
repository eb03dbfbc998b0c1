-- digbox/render.lua - `digbox render REPLAY`: frames of a replay, without simulating again.
--
-- A frame depends on the replay, the options and its number alone, so any split over processes gives the same files. What the
-- options do not say is taken from the script's first film, else as in world:record. lua/render.c forks the workers.

local core = ...

local ON_TIME = 1e-9       -- s; nearer than this a frame falls on a step

local function note(plan, name, frame) return core.reader_note(plan.reader, name, frame) end

local function vector(v) return v and core.vec(v[1], v[2], v[3]) end

-- ---- the plan ----

local function read_pair(text, pattern, what, example)
  local a, b = text:match(pattern)
  a, b = math.tointeger(tonumber(a)), math.tointeger(tonumber(b))
  if not a or not b then core.fail("--%s: '%s' is not of the form %s", what, text, example) end
  return a, b
end

local function names_of(text)
  local list = {}
  for name in text:gmatch "[^,%s]+" do list[#list + 1] = name end
  return list
end

-- The step with which films that show what was before begin; the first of the run when none does.
local function past_begin(plan, films)
  local info, first = plan.info, math.huge
  for _, film in ipairs(films) do
    local overlay = table.concat(film.overlay or {}, ",")
    if overlay:find "trails" or overlay:find "energy" then
      first = math.min(first, math.max(info.first_step, core.first_step_of(film.first, film.fps, info.step)))
    end
  end
  return first < math.huge and first or info.first_step
end

-- The fields world:record would have been given.
local function film_fields(plan, o)
  local films = note(plan, "films", plan.info.frames - 1) or {}
  local film = films[1] or {}
  local f = { size = { film.width or 1280, film.height or 720 }, samples = film.samples, layer = o.layer or film.layer,
    overlay = o.overlay and names_of(o.overlay) or film.overlay }
  if o.size then
    local w, h = read_pair(o.size, "^(%d+)x(%d+)$", "size", "1280x720")
    f.size = { w, h }
  end
  f.samples = o.samples or f.samples
  plan.fps = o.fps or film.fps or 30
  plan.past_step = past_begin(plan, films)
  plan.camera = film.camera and film.camera + 1 or 1
  return f
end

-- Cameras without a name are called by their number, as in the page of digbox view.
local function find_camera(plan, name)
  if not name then return end
  local list = core.reader_cameras(plan.reader, plan.info.frames - 1, false)
  local known = {}
  if #list == 0 then core.fail("--camera: the script of this replay made no camera; without --camera everything is seen") end
  for i, cam in ipairs(list) do
    local own = cam.name ~= "" and cam.name or ("camera %d"):format(i)
    if own == name then
      plan.camera = i
      return
    end
    known[own] = true
  end
  core.unknown("--camera:", "unknown camera", name, known)
end

local function set_range(plan, o)
  local info = plan.info
  local from = info.first_step * info.step
  local till = (info.first_step + info.frames - 1) * info.step
  plan.first = math.ceil(from * plan.fps - ON_TIME * plan.fps)
  plan.count = math.max(0, math.floor(till * plan.fps + ON_TIME * plan.fps) - plan.first + 1)
  plan.from, plan.to = 0, plan.count - 1
  if o.frames then
    local a, b = read_pair(o.frames, "^(%d+)%.%.(%d+)$", "frames", "0..99")
    if a > b then core.fail("--frames: %d..%d goes backwards", a, b) end
    if b >= plan.count then core.fail("--frames: %d..%d, but there are frames 0..%d", a, b, plan.count - 1) end
    plan.from, plan.to = a, b
    plan.part = { a, b }
  end
end

local function set_target(plan, to)
  local folder, name = to:match "^(.*)/([^/]+)$"
  core.options.out = folder and (folder == "" and "/" or folder) or "."
  plan.to_name, plan.said = name or to, to
  plan.video = plan.to_name:match "%.mp4$" or plan.to_name:match "%.webm$"
  if plan.video then
    if plan.options.layer ~= 0 and plan.options.layer ~= 3 then
      core.fail "a video holds the layers colour and normal; write depth and id as PNG"
    end
  elseif not plan.to_name:match "%.png$" then
    core.fail("--output: '%s' must end in .png, .mp4 or .webm", to)
  elseif not core.frame_path(plan.to_name, 0) then
    core.fail("--output: '%s' needs a place for the number: 'f-%%05d.png'", to)
  end
end

-- What a frame depends on besides its number, as text in each PNG: for --resume where there is no manifest.
local function recipe(plan)
  local f = plan.options
  return core.json { size = { f.width, f.height }, samples = f.samples, layer = f.layer, overlay = f.overlay, fps = plan.fps,
    camera = plan.camera, blur = plan.blur, start = core.reader_checksum(plan.reader, 0),
    stop = core.reader_checksum(plan.reader, plan.info.frames - 1), renderer = core.version }
end

-- core.render_plan(options) -> plan
function core.render_plan(o)
  if not core.can_render then core.fail "this build of digbox draws no pictures (it was made with RENDER=0)" end
  local reader, why = core.reader(o.replay)
  if not reader then core.fail("%s", why) end
  local plan = { reader = reader, info = core.reader_info(reader), blur = o.blur or 1 }
  plan.options = core.drawing_options(film_fields(plan, o), "render")
  plan.options.moments = plan.blur > 1 and plan.blur or nil
  core.check_room(plan.options, "render", o.workers)
  find_camera(plan, o.camera)
  set_range(plan, o)
  set_target(plan, o.to or "out/" .. (o.replay:match "([^/]+)$"):gsub("%.%w+$", "") .. "-%05d.png")
  plan.recipe = recipe(plan)
  return plan
end

-- ---- one frame ----

-- What the script says of the camera at a frame: as it left it, or as the step led it there.
local function camera_said(plan, frame, arrived) return core.reader_cameras(plan.reader, frame, arrived)[plan.camera] or {} end

-- Where the camera stands at a moment: as films, blended from where it was before the step to where it came.
local function camera_at(plan, time, view)
  local info, aspect = plan.info, plan.options.width / plan.options.height
  local steps = time / info.step - info.first_step
  local near = math.floor(steps + 0.5)
  if math.abs((near + info.first_step) * info.step - time) <= ON_TIME then
    return core.resolve_camera(camera_said(plan, near, false), view, aspect)
  end
  local frame = math.floor(steps)
  local from, to = (info.first_step + frame) * info.step, (info.first_step + frame + 1) * info.step
  local a, b = camera_said(plan, frame, false), camera_said(plan, frame + 1, true)
  local whole = a.at and a.look_at and b.at and b.look_at
  local before = core.resolve_camera(a, whole and view or core.reader_view(plan.reader, from), aspect)
  local after = core.resolve_camera(b, whole and view or core.reader_view(plan.reader, to), aspect)
  return core.blend_cameras(before, after, (time - from) / info.step)
end

-- The frame of the replay at or before a moment.
local function frame_of(plan, time)
  return math.min(plan.info.frames - 1, math.max(0, math.floor(time / plan.info.step - plan.info.first_step + 1e-6)))
end

local function frame_options(plan, time, view)
  local frame = frame_of(plan, time)
  local light = note(plan, "light", frame) or {}
  local scene = { sun = vector(light.sun), shadows = light.shadows, sky = core.skies[light.sky or "clear"] or 0, lamps = {} }
  for i, lamp in ipairs(light.lamps or {}) do
    scene.lamps[i] = { at = vector(lamp.at), power = lamp.power, colour = vector(lamp.colour) }
  end
  local o = core.frame_options(plan.options, camera_at(plan, time, view), scene)
  return o
end

-- What was before a moment, for overlays: since the first film of the script that showed it began, as that film had it; in other frames
-- since the run began.
local function past_at(plan, time)
  local overlay, info = plan.options.overlay, plan.info
  local trails, energy = overlay & core.overlays.trails ~= 0, overlay & core.overlays.energy ~= 0
  if not trails and not energy then return nil end
  local frame = frame_of(plan, time)
  local since = info.first_step + frame >= plan.past_step and plan.past_step or info.first_step
  if not plan.past or plan.past_since ~= since or frame < plan.past_frame then
    plan.past, plan.past_since = core.past(since, info.step), since
  end
  core.past_read(plan.past, plan.reader, frame, trails, energy)
  plan.past_frame = frame
  return plan.past
end

local function time_of(plan, k) return (plan.first + k) / plan.fps end

-- The view of frame k and its options; with blur also those of the moments after it while the shutter is open, half of a frame's time.
local function look(plan, k)
  local time = time_of(plan, k)
  local past = past_at(plan, time)          -- first: a reader goes on, not back
  local view = core.reader_view(plan.reader, time)
  local views, list = { view }, { frame_options(plan, time, view) }
  list[1].past = past
  for i = 2, plan.blur do
    local moment = time + 0.5 * (i - 1) / plan.blur / plan.fps
    views[i] = core.reader_view(plan.reader, moment)
    list[i] = frame_options(plan, moment, views[i])
  end
  return views, list, time
end

local function texts(plan, k, time)
  local step = math.floor(time / plan.info.step + ON_TIME)
  return { "Software", "digbox " .. core.version, "Time", ("%.17g"):format(time), "Step", ("%d"):format(step), "Frame", ("%d"):format(k),
    "Recipe", plan.recipe, "Renderer", core.renderer() }
end

-- ---- the manifest, and resuming (docs/frames.md) ----

local function facts_of(plan, replay, renderer)
  local facts = { { "replay", core.json(replay) }, { "begins with", "world " .. core.reader_checksum(plan.reader, 0) },
    { "ends with", "world " .. core.reader_checksum(plan.reader, plan.info.frames - 1) },
    { "rate", ("%.17g Hz, from number %d"):format(plan.fps, plan.first) }, { "picture", core.picture_facts(plan.options) },
    { "camera", ("%d"):format(plan.camera) }, { "blur", ("%d"):format(plan.blur) }, { "renderer", renderer } }
  if plan.part then facts[#facts + 1] = { "frames", ("%d..%d"):format(plan.part[1], plan.part[2]) } end
  return facts
end

local function path_of(plan, k) return core.out_path(core.frame_path(plan.to_name, k)) end

-- What the manifest says of frame k besides its bytes
local function entry_of(plan, list, time)
  local step = math.floor(time / plan.info.step + ON_TIME)
  local frame = math.min(plan.info.frames - 1, math.max(0, step - plan.info.first_step))
  for _, o in ipairs(list) do o.history = nil end         -- which the replay and the moment give
  return step, time, core.reader_checksum(plan.reader, frame), core.hash(core.json(list))
end

-- Of a frame that digbox drew before it kept a manifest: may it stay?
local function judge_picture(plan, k, path)
  local made = core.png_text(path, "Recipe")
  if not core.png_whole(path) then
    core.tell(("digbox: render: %s is damaged and is drawn again\n"):format(path))
    return "draw"
  end
  if not made or core.png_text(path, "Frame") ~= ("%d"):format(k) then
    core.tell(("digbox: render: %s was not made by digbox render; it stays as it is\n"):format(path))
    return "foreign"
  end
  if made ~= plan.recipe then
    core.usage("--resume: %s was drawn otherwise\n  there:  %s\n  wanted: %s", path, made, plan.recipe)
  end
  return "keep"
end

-- Whether frame k has to be drawn. A foreign picture stays; of our own the bytes must be those of the manifest.
local function wanted(plan, film, k)
  local path = path_of(plan, k)
  local sum, size = core.sum_file(path)
  if not sum then return true end
  local _, old_size, old_sum = core.frames_kept(film.list, k)
  if sum == old_sum and size == old_size then
    film.kept = film.kept + 1
    return false
  end
  local verdict = judge_picture(plan, k, path)
  if verdict == "keep" and not old_sum then
    local _, list, time = look(plan, k)
    core.frames_add(film.list, k, core.frame_path(plan.to_name, k), size, sum, entry_of(plan, list, time))
    film.kept = film.kept + 1
  end
  return verdict == "draw" or verdict == "keep" and old_sum ~= nil
end

-- core.render_begin(plan, replay, mode, renderer) -> list of the frames to draw. Opens the manifest of a film of files; mode is "new",
-- "resume" or "force".
function core.render_begin(plan, replay, mode, renderer)
  local list, film = {}, nil
  if plan.video then
    local path = core.out_path(plan.to_name)
    if mode == "new" and core.exists(path) then core.usage("%s: a film is there; --force draws it anew", path) end
  else
    film = { pattern = plan.to_name, part = plan.part }
    core.open_list(film, facts_of(plan, replay:match "([^/]+)$" or replay, renderer), mode)
    plan.film = film
  end
  for k = plan.from, plan.to do
    if mode ~= "resume" or plan.video or wanted(plan, film, k) then list[#list + 1] = k end
  end
  return list
end

-- core.render_list(plan, frames, fds): the workers' entries in the order of the frames; stops at a signal
function core.render_list(plan, frames, fds)
  local film, ended = plan.film, {}
  for i = 1, #frames do
    local worker = (i - 1) % #fds + 1
    if core.stopped() then return end
    if not ended[worker] then
      ended[worker] = not core.frames_take(film.list, fds[worker])
      film.drawn = film.drawn + (ended[worker] and 0 or 1)
    end
  end
end

-- core.render_end(plan, fds, count of frames to draw): what workers that were stopped still send, and the end of the manifest
function core.render_end(plan, fds, count)
  local film = plan.film
  for _, fd in ipairs(fds) do
    while core.frames_take(film.list, fd) do film.drawn = film.drawn + 1 end
  end
  local whole = film.drawn == count
  if film.kept > 0 or not whole then
    core.tell(("digbox: %s: %d frames were there, %d were drawn%s\n"):format(film.manifest, film.kept, film.drawn,
      whole and "" or "; go on with --resume"))
  end
  core.frames_close(film.list, whole and plan.to - plan.from + 1 or nil)
end

-- ---- working ----

-- core.render_work(plan, frames, worker, workers, fd): every workers-th frame, into files, whose entries go to the process that holds
-- the manifest, or as pixels
function core.render_work(plan, frames, worker, workers, fd)
  for i = worker + 1, #frames, workers do
    if core.stopped() then return end
    local k = frames[i]
    local views, list, time = look(plan, k)
    if plan.video then
      core.pixels(views, list, fd)
    else
      local size, sum = core.picture(views, list, path_of(plan, k), texts(plan, k, time))
      core.frames_send(fd, k, core.frame_path(plan.to_name, k), size, sum, entry_of(plan, list, time))
    end
  end
end

-- core.render_collect(plan, frames, fds): the workers' frames in their order into ffmpeg
function core.render_collect(plan, frames, fds)
  local o = plan.options
  local path = core.out_path(plan.to_name)
  local pipe = core.pipe(path, o.width, o.height, plan.fps)
  if not pipe then core.fail("%s: there is no ffmpeg here; frames can be had as 'f-%%05d.png'", path) end
  for i = 1, #frames do
    if core.stopped() or not pipe:copy(fds[(i - 1) % #fds + 1]) then
      pipe:drop()
      return false
    end
  end
  pipe:close()
  return true
end

return true
