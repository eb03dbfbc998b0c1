-- digbox/interface.lua - declarations (see declare.lua) of the functions, methods and properties that are written in C, and of events.

local core = ...
local declare, declare_type, event = core.declare, core.declare_type, core.declare_event
local methods = {}
for name, t in next, core.types do methods[name] = t.methods end

local AT = { "vec m", "where, in world coordinates" }
local LAYERS = { "mechanical", "electrical", "thermal", "hydraulic", "range" }
local KINDS = { "contact", "joint", "electrical", "thermal", "hydraulic", "range" }
core.layer_names, core.link_kind_names = LAYERS, KINDS

-- ---- values ----

declare("digbox.vec", { "Makes a vector.", takes = { { "x", "real", "first component, or a table {x, y, z}" },
  { "y", "real", "second component", optional = true }, { "z", "real", "third component", optional = true } }, gives = "vector" })
declare("digbox.quat", { "Makes a rotation: about an axis, from one direction to another, or of four numbers {x, y, z, w} of length 1.",
  fields = { axis = { "dir 1", "what to turn about", default = "{0, 1, 0}" },
    angle = { "real rad", "how far, by the right-hand rule", default = 0 },
    from = { "dir 1", "a direction before; goes with `to`", default = "{0, 1, 0}" },
    to = { "dir 1", "where that direction points after, by the shortest way", default = "{0, 1, 0}" } }, gives = "rotation" })
declare("digbox.path", { "The bodies on a shortest way through the links of a DIG, both ends included; empty when there is none.",
  takes = { { "a", "body", "where it begins" }, { "b", "body", "where it ends" } },
  fields = { kind = { "text", "only over links of that kind or layer", of = KINDS } }, optional = true, gives = "body[]" })

declare_type("vector", "A vector: never changes; + - * / and == work on it, #v is its length. {x, y, z} is accepted wherever a vector is.",
  methods.vector, { x = { "number", "first component" }, y = { "number", "second component" }, z = { "number", "third component" } })
declare("vector:dot", { "The scalar product.", takes = { { "other", "vec", "the other vector" } }, gives = "number" })
declare("vector:cross", { "The vector product.", takes = { { "other", "vec", "the other vector" } }, gives = "vector" })
declare("vector:length", { "The length, as #v.", gives = "number" })
declare("vector:normalized", { "The vector of length 1 in the same direction.", gives = "vector" })
declare("vector:unpack", { "Its three components.", gives = "number, number, number" })

declare_type("rotation", "A rotation (unit quaternion): q * r turns by r, then by q; q * v turns a vector.", methods.rotation, {
  x = { "number", "first component" }, y = { "number", "second component" }, z = { "number", "third component" },
  w = { "number", "real part" }, angle = { "number", "how far it turns, 0 to pi", unit = "rad" },
  axis = { "vector", "what it turns about" } })
declare("rotation:rotate", { "Turns a vector.", takes = { { "v", "vec", "the vector" } }, gives = "vector" })
declare("rotation:inverse", { "The rotation back.", gives = "rotation" })

declare_type("shape", "A shape to build bodies of, to ask with and to bound regions by; made by digbox.box{...} and its like.",
  methods.shape)

-- ---- the world ----

declare_type("world", "A world: all bodies, joints and laws of one simulation. digbox.world{...} makes one.", methods.world, {
  time = { "number", "steps times step, never summed", unit = "s" },
  steps = { "integer", "frame steps so far" },
  frame = { "number", "length of a frame step", unit = "s" },
  gravity = { "vector", "acceleration of gravity", unit = "m/s^2", set = true },
  accuracy = { "string", "name of the accuracy, or the tolerance as a number of metres", set = true },
  momentum = { "vector", "sum over all bodies that move", unit = "kg m/s" },
  angular_momentum = { "vector", "sum over all bodies that move, about the origin", unit = "kg m^2/s" },
  energy = { "table", "books: kinetic potential elastic heat electric total, initial, work_in law lost numerical", unit = "J" },
  seed = { "integer", "of all random numbers" },
  tasks = { "integer", "tasks that still run" } })
declare("world:bodies", { "All bodies, in the order they were made.", gives = "body[]" })
declare("world:joints", { "All joints, in the order they were made.", gives = "joint[]" })
declare("world:find", { "The body or joint of that name, or else the truss, plank, cloth, lattice or rope; the first, or nil.",
  takes = { { "name", "text", "its name" } }, gives = "body|joint|truss|plank|cloth|lattice|rope|nil" })
declare("world:digs", { "All dynamic interaction graphs of a layer.",
  takes = { { "layer", "text", "which", optional = true, of = LAYERS, default = "mechanical" } }, gives = "DIG[]" })
declare("world:checksum", { "A number of the whole state, as text: equal states give equal ones.", gives = "string" })
declare("world:check", { "Raises an error when the world's records contradict each other." })
declare("world:stats", { "What the last step did and cost: bodies, awake, digs, contacts, pairs, residual, bytes, us by phase, ...",
  gives = "table" })
declare("world:snapshot", { "Keeps the present state, to come back to.", gives = "snapshot" })
declare("world:warnings", { "What the world found wrong with itself so far: {rule, time, body, value, bound, unit, reason, advice}.",
  gives = "table[]" })
declare("world:messages", { "The last 4096 messages, oldest first: {id, time, from, to, kind, value, values}.", gives = "table[]" })
declare("world:effects", { "Every effect by name: {on, why, bodies, us, us_mean, bytes, calls, law, options}.", gives = "table" })
declare("world:effect", { "Switches an effect on or off, or sets its options.", takes = { { "name", "text", "which effect" },
  { "how", "any", "true, false or a table of options", type = "boolean|table" } } })
local question = {
  along = { "vec", "which way, world axes" },
  turn = { "vec", "or about which axis, through the centre of mass" },
  by = { "any", "how far: m, or rad with turn", type = "number|string", default = "1 cm or 0.01 rad" },
  with = { "any", "how hard: N, or N m with turn; not given: the answer says how much it needs", type = "number|string" },
  at = { "vec m", "where it is pushed", default = "the centre of mass" },
  within = { "real s >0", "how long at most", default = 5 } }
declare("world:ask", { "Whether a body can move in a certain way, by trying it on a copy: the world stays as it is.",
  fields = core.join_fields(question, { body = { "body", "who is to move", need = true } }), gives = "answer" })
declare("world:ray", { "What a ray meets, nearest first: {body, point, normal, distance, fraction}.", fields = {
  from = { "vec m", "where it begins", need = true }, to = { "vec m", "where it ends" },
  along = { "vec", "or its direction" }, length = { "real m", "how long, with along", default = 10000 } }, gives = "hit[]" })
local shape_at = { shape = { "any", "a shape, also as the first item or as sphere = {...}, box = {...}", type = "shape" },
  at = { "vec m", "where it stands", default = "{0, 0, 0}" }, rotation = { "quat 1", "how it is turned" } }
declare("world:overlap", { "The bodies that a shape would overlap.", fields = shape_at, gives = "body[]" })
declare("world:sweep", { "What a shape meets first on its way, or nil.", fields = core.join_fields(shape_at, {
  velocity = { "vec m/s", "its velocity", default = "{0, 0, 0}" },
  acceleration = { "vec m/s^2", "its acceleration", default = "{0, 0, 0}" }, time = { "real s", "for how long", default = 1 },
  from = { "vec m", "or where its way begins" }, to = { "vec m", "where that ends" },
  along = { "vec", "or its direction" }, length = { "real m", "how long, with along", default = 10000 } }),
  gives = "hit|nil" })
declare("world:link", { "Links two bodies in a layer other than the mechanical one.", fields = {
  a = { "body", "one end", need = true }, b = { "body", "the other", need = true },
  layer = { "text", "which layer", need = true, of = { "electrical", "thermal", "hydraulic", "range" } },
  bound = { "bool", "b is a boundary of the layer, such as earth, and joins no DIG", default = false },
  ratio = { "real", "what arrives at b for 1 at a, for messages by ratio" } }, gives = "link" })
declare("world:body", { "Makes a body of several shapes.", fields = {
  parts = { "any", "list of shapes such as digbox.box{...}", type = "shape[]", need = true } }, with = { "body" }, gives = "body" })

local LANDSCAPE = "A landscape: a height at each point of a grid. Ground from above only: what comes from below passes through."
local HEIGHTS = { heights = { "any", "list of rows of heights, instead of rows and columns", type = "number[][]" },
  height = { "any", "gives the height at x, z in m, for each of rows and columns", type = "function" },
  size = { "any", "extents along x and z: {x, z}, or {x, y, z} whose y is ignored", type = "number[]|vector", need = true } }
declare("world:heightfield", { LANDSCAPE, fields = HEIGHTS, with = { "shape heightfield", "body" },
  gives = "body" })
declare("digbox.heightfield", { LANDSCAPE, fields = HEIGHTS, with = { "shape heightfield", "part" },
  gives = "shape" })

declare_type("snapshot", "A state of a world that world:restore brings back.", methods.snapshot)

declare_type("region", "A part of space with laws of its own.", methods.region, { valid = { "boolean", "it was not removed" } })
declare("region:bodies", { "The dynamic bodies whose centre of mass is inside.", gives = "body[]" })
declare("region:remove", { "Takes it away: the laws of the world hold again." })

declare_type("link", "A link of a layer other than the mechanical one.", methods.link, {
  valid = { "boolean", "it is still there" }, layer = { "string", "its layer" } })
declare("link:remove", { "Takes the link away." })
declare("link:set", { "What flows through it now, in the units of its layer: effort times flow is power.", takes = {
  { "effort", "real", "such as a voltage or a temperature" }, { "flow", "real", "such as a current or an entropy flow" } } })

-- ---- bodies ----

declare_type("body", "A body. Its fields as listed under body fields can be read, and assigned where they are no state.", methods.body, {
  position = { "vector", "of its origin", unit = "m" }, centre = { "vector", "its centre of mass", unit = "m" },
  rotation = { "rotation", "its orientation" },
  velocity = { "vector", "of its centre of mass", unit = "m/s" }, speed = { "number", "length of the velocity", unit = "m/s" },
  spin = { "vector", "angular velocity", unit = "rad/s" },
  mass = { "number", "its mass; of a fixed or kinematic one as given, else infinite", unit = "kg", set = true },
  inertia = { "number[][]", "inertia tensor about the centre of mass, world axes, as rows", unit = "kg m^2" },
  awake = { "boolean", "it is being solved" }, asleep = { "boolean", "it rests and costs nothing" },
  valid = { "boolean", "it was not removed" }, dig = { "DIG|nil", "the DIG it belongs to; static bodies are in none" },
  energy = { "number", "kinetic and potential: of gravity, which is 0 at the origin", unit = "J" },
  force = { "vector", "sum of the forces of the last step", unit = "N" },
  torque = { "vector", "sum of the torques of the last step", unit = "N m" },
  bounds = { "table", "{low, high}: corners of the box around it", unit = "m" },
  mode = { "string", "moving, resting or fixed" }, kind = { "string", "dynamic, kinematic or static" },
  integrating = { "string", "euler while it has no history, else verlet" },
  debug = { "table", "the record of the founding document, appendix B; me, you and direction are of the last message" },
  name = { "string", "for messages, events and world:find", set = true },
  work_received = { "number", "work of pushes on it", unit = "J" }, world = { "world", "its world" },
  data = { "any", "any value that the script wants to keep with it", set = true } })
declare("body:push", { "Pushes with a force, from the next step on, held through a step (springs gain energy so: add_effect).", fields = {
  force = { "amount N", "a vector, or how much along `along`", need = true }, along = { "vec", "its direction when force is a number" },
  at = { "vec m", "the point that is pushed", default = "the centre of mass" },
  lasts = { "real s >=0", "for how long", default = "one frame step" } }, gives = "body" })
declare("body:twist", { "Turns with a torque, from the next step on.", fields = {
  torque = { "amount N*m", "a vector, or how much about `along`", need = true }, along = { "vec", "its axis when torque is a number" },
  lasts = { "real s >=0", "for how long", default = "one frame step" } }, gives = "body" })
declare("body:hit", { "Changes its momentum at once.", fields = {
  impulse = { "amount N*s", "a vector, or how much along `along`", need = true },
  along = { "vec", "its direction when impulse is a number" },
  at = { "vec m", "the point that is hit", default = "the centre of mass" } }, gives = "body" })
declare("body:teleport", { "Puts it somewhere else at once; what is not given stays.", fields = {
  at = AT, rotation = { "quat 1", "its new orientation" },
  velocity = { "vec m/s", "its new velocity" }, spin = { "vec rad/s", "its new angular velocity" } }, gives = "body" })
declare("body:move_to", { "Moves a kinematic body there in a given time.", fields = {
  at = AT, rotation = { "quat 1", "its orientation then" },
  over = { "real s >=0", "how long it takes, rounded up to whole frame steps: never faster than asked", default = "one frame step" } },
  gives = "body" })
declare("body:drive", { "Keeps a kinematic body moving.", fields = {
  velocity = { "vec m/s", "its velocity", default = "{0, 0, 0}" }, spin = { "vec rad/s", "its angular velocity", default = "{0, 0, 0}" } },
  gives = "body" })
declare("body:wake", { "Wakes it and its DIG.", gives = "body" })
declare("body:disable", { "Sets it aside for good: it stands where it is, nothing touches it, and its joints are gone.", gives = "body" })
declare("body:remove", { "Takes it out of the world, and its joints with it." })
declare("body:touches", { "Whether it touches the other body now.", takes = { { "other", "body", "the other body" } }, gives = "boolean" })
declare("body:contains", { "Whether the other's centre of mass is inside its outline.", takes = { { "other", "body", "the other body" } },
  gives = "boolean" })
declare("body:velocity_at", { "Velocity of the material point there, m/s.", takes = { { "point", "vec m", "a point of the world" } },
  gives = "vector" })
declare("body:neighbours", { "The bodies it is linked with.", fields = { kind = { "text", "only by links of that kind or layer",
  of = KINDS } },
  optional = true, gives = "body[]" })
declare("body:links", {
  "Its links: {a, b, kind, effort, flow, power, began, point, normal}; effort times flow is power (of vectors effort:dot(flow)).",
  fields = { kind = { "text", "only of that kind or layer", of = KINDS } }, optional = true, gives = "table[]" })
declare("body:dig_of", { "The DIG of a layer that it belongs to, or nil.",
  takes = { { "layer", "text", "which layer", optional = true, of = LAYERS, default = "mechanical" } }, gives = "DIG|nil" })
declare("body:can_move", { "Whether it can move in a certain way, who holds it and why, by trying it on a copy: the world stays as it is.",
  fields = question, gives = "answer" })
declare("body:warm", { "Gives it heat, or brings it to a temperature.", fields = {
  energy = { "real J", "so much heat" }, to = { "real K", "or up to this temperature" } }, gives = "body" })

declare_type("answer", "What a question found out.", {}, {
  verdict = { "string", "free (all the way), blocked, needs, conflict or unknown" }, ok = { "boolean", "it can be done as asked" },
  needs = { "number|nil", "the least force or torque that starts it, or gets it on from there, N or N m" },
  moved = { "number", "how far it came, m or rad" },
  time = { "number", "how long that took", unit = "s" },
  blocked_by = { "body|joint|string|nil", "who is in the way; a wall of the room by its name" },
  held_by = { "body|joint|string|nil", "who holds it: the same" }, holders = { "table", "all of those, the first first" },
  chain = { "table", "the way that the message took, from it by who holds it to what stands firm: bodies and joints" },
  consequences = { "table", "what else would move or break: {what, who, amount}" },
  because = { "string", "the reason, in one sentence" }, trials = { "integer", "how many copies were tried" },
  steps = { "integer", "steps of all trials" } })
declare_type("hit", "A place where a ray or a moving shape meets a body.", {}, {
  body = { "body", "the body; nil: a wall of the room" }, point = { "vector", "where", unit = "m" },
  normal = { "vector", "the surface's normal there" }, distance = { "number", "from the start", unit = "m" },
  fraction = { "number", "share of the way" } })

-- ---- joints ----

declare_type("joint", "A joint. Its parameters (motor, limits, ...) are read and set as fields, whole: joint.motor = { speed = 5 }; "
  .. "nil takes one away.", methods.joint, {
  type = { "string", "hinge, slider, ..." }, name = { "string", "its name" },
  a = { "body", "one body" }, b = { "body|nil", "the other; nil: the world" },
  at = { "vector", "where it is now", unit = "m" },
  angle = { "number", "of a hinge or wheel, from where it began", unit = "rad" },
  distance = { "number", "of a slider, spring or rope", unit = "m" },
  speed = { "number", "rate of angle or distance", unit = "rad/s or m/s" },
  force = { "vector", "by which it holds a", unit = "N" }, torque = { "vector", "by which it holds a", unit = "N m" },
  error = { "number", "how far it is from where it should be", unit = "m" },
  stress = { "number", "load over limit; 1 breaks" },
  at_limit = { "boolean", "it is at one of its limits" }, valid = { "boolean", "it is still there" } })
declare("joint:set", { "Changes parameters of its type, such as motor, limits or stiffness, breaks_at and collides; false takes one away.",
  takes = { { "parameters", "table", "fields of that type of joint" } }, gives = "joint" })
declare("joint:remove", { "Takes the joint away." })
declare("joint:withdraw", { "The same, as one says of a bolt." })

-- ---- DIGs ----

declare_type("DIG", "A dynamic interaction graph: the bodies that act on each other now, in one layer.", methods.DIG, {
  id = { "integer", "never used twice" }, layer = { "string", "its layer" }, size = { "integer", "number of members" },
  awake = { "boolean", "it is being solved" }, energy = { "number", "kinetic and potential energy of its members", unit = "J" },
  plan = { "string", "the accuracy it is solved with" }, valid = { "boolean", "it did not merge or dissolve" } })
declare("DIG:members", { "Its bodies.", gives = "body[]" })
declare("DIG:links", { "Its links, as body:links gives them.", gives = "table[]" })
declare("DIG:accuracy", { "Solves this DIG with another accuracy: care where one looks.",
  takes = { { "accuracy", "any", "sketch, play, study, reference, or a tolerance such as '1 um'", type = "string|number" } },
  gives = "DIG" })

-- ---- events ----

event("contact_begin", "Two bodies begin to touch. What lies there from the start tells it in the first step, at no speed.",
  "time self other speed impulse point normal")
event("contact_end", "They do not touch any more. `point`: in the middle between where they are nearest now.",
  "time self other point normal")
event("impact", "They hit each other. What rides on a mover is not hit by it.", "time self other speed impulse point normal")
event("broken", "A joint broke.", "time self other joint stress")
event("moved", "A body moved during the step; told of each that did, in each step, not of what rests.", "time self")
event("slept", "A body fell asleep.", "time self")
event("woke", "A body woke.", "time self")
event("removed", "A body was removed.", "time self")
event("disabled", "A body was set aside: by body:disable, or since a number of it was not finite any more; a handler that returns true "
  .. "has dealt with the latter, and the run does not end with exit code 10.", "time self")
event("entered", "A body came into a region.", "time self region")
event("left", "A body went out of a region.", "time self region")
event("limit_reached", "A joint reached one of its limits.", "time self other joint")
event("out_of_world", "A body left the room, or came 10 km away from the origin where there is none; told once. It goes on.", "time self")
event("link", "A link came into being; of other layers than the mechanical one with { layer = ... }.", "time self other kind layer dig")
event("unlink", "A link went away.", "time self other kind layer dig")
event("merged", "Two DIGs became one: `dig`. Told by body:on to each of its members.", "time self dig other_dig layer")
event("split", "A DIG fell apart into `dig` and `other_dig`. Told by body:on to each of their members.", "time self dig other_dig layer")
event("message", "A message arrives; heard by body:on of its receiver, and by world:on.", "time from to kind value values direction")

declare_type("event", "What a handler gets: a copy of its own, safe to keep. Which fields it has depends on the event.", {}, {
  event = { "string", "its name" }, time = { "number", "when", unit = "s" }, self = { "body", "the body asked about" },
  other = { "body|room|nil", "the body it met, or the room" }, speed = { "number", "closing speed", unit = "m/s" },
  a = { "body|nil", "the body with the lower number" }, b = { "body|nil", "the other one" },
  impulse = { "number", "of the blow", unit = "N s" }, stress = { "number", "load over limit of a joint that broke" },
  point = { "vector", "where", unit = "m" }, normal = { "vector", "from self to other" }, joint = { "joint|nil", "the joint" },
  dig = { "DIG|nil", "the DIG" }, other_dig = { "DIG|nil", "the other DIG" }, wall = { "string|nil", "the wall of the room" },
  region = { "region|nil", "the region" }, kind = { "string|nil", "of a link; name of a message" }, layer = { "string|nil", "of a link" },
  from = { "body|nil", "who sent it" }, to = { "body|nil", "who gets it" }, value = { "number|nil", "first number of a message" },
  values = { "number[]|nil", "its four numbers" }, direction = { "vector|nil", "from sender to receiver" } })

return true
