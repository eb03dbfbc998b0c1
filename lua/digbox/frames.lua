-- digbox/frames.lua - the frames of a film as files: written whole, listed in a manifest beside them, kept when a run is resumed
-- (docs/frames.md).

local core = ...

local STILL = 100       -- frames that show the same picture are told of when there are more

-- "f-%05d.png" -> "f-manifest.sha256", "%d/eye.png" -> "manifest-eye.sha256", and the part of the pattern that its names leave out.
-- part: the numbers of its first and last frame, of a film that is drawn in parts -> "f-manifest-10-19.sha256"
local function manifest_of(pattern, part)
  local before, after = pattern:match "^([^%%]*)%%0?%d*d(.*)%.png$"
  local folder, stem = before:match "^(.*/)([^/]*)$"
  local numbers = part and ("-%d-%d"):format(part[1], part[2]) or ""
  return before .. "manifest" .. numbers .. after:gsub("/", "-") .. ".sha256", folder or "", stem or before
end

-- What a film's frames depend on, as the head of its manifest: a line for each {key, value}.
local function head_of(film, manifest, facts)
  local lines = { "# digbox frames 1", "# check them: digbox verify FOLDER, or sha256sum -c " .. manifest:sub(#film.folder + 1),
    "# film: " .. core.json(film.pattern:sub(#film.folder + 1)), "# program: digbox " .. core.version }
  for _, fact in ipairs(facts) do lines[#lines + 1] = ("# %s: %s"):format(fact[1], fact[2]) end
  return table.concat(lines, "\n") .. "\n"
end

function core.picture_facts(o)
  return core.json { size = { o.width, o.height }, samples = o.samples, smooth = o.smooth, layer = o.layer, overlay = o.overlay }
end

-- All that the frames of a run's film depend on, besides their numbers
local function facts_of(film)
  local world, options = film.world, core.options
  return {
    { "script", core.json(options.script_name or "") }, { "script hash", options.script_hash or "none" },
    { "arguments", core.json(options.args or {}) }, { "set", core.json(options.set or {}) },
    { "seed", ("%d"):format(core.state(world).seed or 0) }, { "accuracy", core.json(world.accuracy) },
    { "step", ("%.17g s"):format(world.frame) }, { "rate", ("%.17g Hz, from number %d"):format(film.fps, film.first) },
    { "picture", core.picture_facts(film.options) }, { "renderer", core.renderer() } }
end

local function mode_of()
  local options = core.options
  if options.mode ~= "run" or options.force then return "force" end
  return options.resume and "resume" or "new"
end

-- Frames that were written before there was a manifest, or whose manifest is gone
local function refuse_others(film, mode)
  local path = core.out_path(core.frame_path(film.pattern, film.part and film.part[1] or 0))
  if mode == "new" and core.exists(path) then
    core.usage("%s is there already; --force takes the film anew, --resume too where digbox made the frames", path)
  end
end

-- The manifest, before the first frame, and what an earlier run left. What is there is not overwritten unless the user said so.
-- film: pattern, part; facts: what its frames depend on; mode: "new", "resume" or "force"
function core.open_list(film, facts, mode)
  local manifest, folder = manifest_of(film.pattern, film.part)
  film.folder = folder
  local path = core.out_path(manifest)
  for other in next, core.open_films or {} do
    if other.manifest == path then core.fail("world:record: '%s' is being filmed already", film.pattern) end
  end
  core.sweep(path)
  if not core.exists(path) then refuse_others(film, mode) end
  local list, why, code = core.frames_open(path, head_of(film, manifest, facts), mode)
  if not list then core.raise(code, code == 9 and core.where() .. why or why) end
  film.list, film.manifest, film.kept, film.drawn = list, path, 0, 0
  for index, name in next, why do
    if name == core.frame_path(film.pattern, index):sub(#folder + 1) then core.remove(core.out_path(folder .. name)) end
  end
end

-- Before the first frame of a run's film
function core.begin_frames(film)
  if not core.options.dry then core.open_list(film, facts_of(film), mode_of()) end
end

-- Is what stands in the frame's place of an earlier run, whole, and of this film? Says so when it is not.
local function is_kept(film, k, path, world, scene)
  local _, size, sum, old_world, old_scene = core.frames_kept(film.list, k)
  if size and (old_world ~= world or old_scene ~= scene) then
    core.usage("--resume: frame %d (%s) shows another %s: the run does not go as it went before", k, path,
      old_world ~= world and ("world, %s, now %s"):format(old_world, world) or "scene")
  end
  local now, bytes = core.sum_file(path)
  if not now then return false end
  if now == sum and bytes == size then return true end
  if not core.png_whole(path) then
    core.tell(("digbox: %s is damaged and is drawn again\n"):format(path))
  elseif not (core.png_text(path, "Software") or ""):match "^digbox " then
    core.tell(("digbox: %s was not made by digbox; it stays as it is, and the film lacks frame %d\n"):format(path, k))
    return true, true
  end
  return false
end

-- A frame that cannot be written ends its film: what came after it would stand in a wrong place.
local function give_up(film, k, why)
  core.drop_film(film)
  if core.exit_code(why) ~= 9 then error(why, 0) end
  local place = core.where()
  if why:sub(1, #place) == place then why = why:sub(#place + 1) end
  core.raise(9, ("%sframe %d: %s; %d frames are complete%s"):format(place, k, why, k,
    core.options.mode == "run" and "; once it can be written, go on with --resume" or ""))
end

-- Frames that may not be what the film was meant to show
local function look_at(film, k, plain, pixels)
  if plain then film.plain, film.first_plain = (film.plain or 0) + 1, film.first_plain or k end
  if pixels ~= film.pixels then film.pixels, film.since = pixels, k end
  local stretch = k - film.since + 1
  if stretch > (film.longest or STILL) then film.longest, film.still = stretch, film.since end
end

local function warn(film)
  if core.options.mode ~= "run" or core.options.quiet then return end
  if film.plain then
    core.tell(("digbox: %s: %d frames have one colour, the first is frame %d\n"):format(film.pattern, film.plain, film.first_plain))
  end
  if film.longest then
    core.tell(("digbox: %s: %d frames from frame %d on show the same picture\n"):format(film.pattern, film.longest, film.still))
  end
end

-- core.put_frame(film, k, view, options of the frame, texts, time): frame k under its name and in the manifest
function core.put_frame(film, k, view, o, texts, time)
  if core.options.dry then return end
  local name = core.frame_path(film.pattern, k)
  local path = core.out_path(name)
  local world, scene = film.world:checksum(), core.hash(core.json(o))
  if core.options.resume then
    local kept, foreign = is_kept(film, k, path, world, scene)
    if kept then
      film.kept = film.kept + (foreign and 0 or 1)
      return
    end
  end
  local ok, why = pcall(function()
    local size, sum, plain, pixels = core.picture(view, o, path, texts)
    look_at(film, k, plain, pixels)
    core.frames_add(film.list, k, name:sub(#film.folder + 1), size, sum, film.world.steps, time, world, scene)
  end)
  if not ok then give_up(film, k, why) end
  film.drawn = film.drawn + 1
end

-- No frame comes any more; whole: the film came to its end.
function core.end_frames(film, whole)
  if not film.list then return end
  local list = film.list
  film.list = nil
  warn(film)
  if core.options.resume and not core.options.quiet then
    core.tell(("digbox: %s: %d frames were there, %d were drawn\n"):format(film.manifest, film.kept, film.drawn))
  end
  core.frames_close(list, whole and film.frames or nil)
end

return true
