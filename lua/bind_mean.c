/* lua/bind_mean.c - names by their meaning: what those write who know another program or another language, and what it is called here.
 *
 * The spelling of a name is dig_suggest's; here are the words that no edit leads to. A row is tried in every place and counts where
 * one of its answers is known: `pos` is `at` to world:ball and `position` to a body.
 */

#include "bind.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

enum { WORD = 48 };             /* bytes of a word, with its end */

/* Words in small letters without '_'; answers in the order of preference. */
typedef struct Meaning { const char *words, *answers; } Meaning;

static const Meaning meanings[] = {
    /* where things are and how they move */
    {"setposition setpos setvelocity setlinearvelocity setangularvelocity setvel setspin setrotation setorientation settransform setpose "
     "resetbasepositionandorientation resetbasevelocity setworldtransform translate warp place goto setlinvel setangvel setqpos",
     "teleport"},
    {"move moveto moveposition setkinematicposition movekinematic", "move_to teleport"},
    {"rotate turn rotateto", "teleport"},
    {"pos location translation origin xyz coordinates coords x y z getx gety getz basepos qpos eye", "position at"},
    {"position centre center", "at centre"},
    {"com centerofmass centreofmass worldcenter massposition", "centre"},
    {"offset from start", "at"},
    {"to end until", "at_b"},
    {"orientation quaternion quat rot euler rpy eulerangles angles heading attitude axisangle orn transform pose matrix angle", "rotation position"},
    {"vel linearvelocity linvel linear speed qvel", "velocity motor"},
    {"angularvelocity angvel angular omega rotationspeed rotationalvelocity", "spin"},
    {"velocity targetvelocity motorspeed targetspeed rate rpm vel", "speed motor"},
    {"rotation orn euler quat", "turn rotation"},
    /* what they are */
    {"static isstatic immovable anchored pinned frozen freeze locked stationary anchor bodytype immobile usefixedbase motiontype", "fixed"},
    {"type", "fixed kind"},
    {"dynamic isdynamic", "fixed"},
    {"animated moving scripted", "kinematic"},
    {"weight m", "mass"},
    {"rho", "density"},
    {"color rgb rgba tint paint diffuse hue texture", "colour"},
    {"alpha transparency", "opacity"},
    {"bounce bounciness bouncy elasticity cor rebound elastic coefficientofrestitution springiness", "restitution"},
    {"mu grip frictioncoefficient staticfriction lateralfriction surfacefriction coefficientoffriction traction slide", "friction"},
    {"dynamicfriction kineticfriction slidingfriction", "friction_dynamic"},
    {"rollingresistance rollfriction spinningfriction rolling", "rolling_friction"},
    {"lineardamping angulardamping airresistance airdrag drag damping", "drag_coefficient damping"},
    {"usegravity gravity gravityfactor gravityenabled affectedbygravity", "gravity_scale"},
    {"trigger issensor sensor istrigger ghost collidable collision collide collisions collisionenabled cancollide", "collides"},
    {"layer mask category categorybits maskbits filter collisiongroup collisionfilter layers", "group"},
    {"title label id tag key", "name"},
    {"userdata user custom properties attributes extra", "data"},
    {"substance stuff surface", "material"},
    {"depth height surface", "level"},
    {"radius diameter r", "radius top_radius"},
    {"gravity drag force", "laws"},
    {"magnitude len norm mag size abs", "length"},
    {"normalize unit unitvector direction", "normalized"},
    {"dimensions dims dimension extents extent scale sides halfextents halfsize width height depth length resolution res w h", "size"},
    {"diameter r rad d", "radius"},
    {"length l depth", "height"},
    {"height h", "length"},
    {"vertices verts vertexes", "vertices points"},
    {"indices faces tris elements", "triangles"},
    {"shape shapes children colliders fixtures geom geoms collisionshape compound", "parts"},
    {"temp heat", "temperature"},
    /* what is done to them */
    {"applyforce addforce force applycentralforce applyexternalforce setforce applyforcetocenter applylocalforce thrust addrelativeforce pull",
     "push force"},
    {"applyimpulse addimpulse impulse kick strike applylinearimpulse applycentralimpulse impact shove", "hit impulse"},
    {"applytorque addtorque torque applytorqueimpulse settorque applyexternaltorque spinup", "twist torque"},
    {"destroy delete kill dispose despawn removebody destroybody deletebody free", "remove"},
    {"oncontact oncollision ontrigger oncollisionenter ontriggerenter oncollide onhit", "on"},
    {"sleep putosleep sleeping issleeping isasleep", "asleep"},
    {"wakeup activate isawake active isactive", "awake wake"},
    {"deactivate disabled off setenabled", "disable off"},
    {"contacts getcontacts touching collisions colliding getcontactpoints overlapping contactlist getcollisions", "neighbours touches"},
    {"iscolliding istouching collideswith intersects", "touches"},
    {"aabb boundingbox getaabb box bbox", "bounds"},
    {"connections joined joints constraints getjoints", "joints links"},
    {"duration time seconds for timespan period", "lasts seconds"},
    {"direction dir axis normal toward towards heading", "along axis turn"},
    {"point position pos location where anchor pivot origin contactpoint", "at"},
    {"magnitude amount strength value newtons power", "force impulse torque power"},
    {"distance dist amount", "by length distance"},
    {"newtonseconds momentum force", "impulse"},
    /* the world */
    {"dt timestep fixedtimestep deltatime stepsize delta fixeddt substep hz", "step"},
    {"g setgravity gravitational grav", "gravity"},
    {"randomseed rng random", "seed"},
    {"quality precision solver iterations substeps solveriterations fidelity", "accuracy"},
    {"cores workers jobs cpus numthreads", "threads"},
    {"tick update stepsimulation advance stepsim simulatestep", "step"},
    {"simulate play start go loop mainloop execute begin runfor simulatefor forward mjstep", "run"},
    {"t now clock elapsed simtime gettime getcurrenttime simulationtime currenttime", "time"},
    {"frames ticks", "steps"},
    {"until condition stop stopwhen while", "stop_when"},
    {"get getbody lookup findbody byname getbyname body object query", "find"},
    {"objects things getbodies entities actors children rigidbodies bodylist", "bodies"},
    {"constraints getjoints jointlist", "joints"},
    {"raycast rayquery rayqueryclosest castray linecast intersect raytest pick", "ray"},
    {"overlapsphere overlapbox queryaabb overlaptest", "overlap"},
    {"shapecast spherecast sweeptest", "sweep"},
    {"cube crate brick block cuboid rect rectangle wall", "box"},
    {"orb globe", "ball sphere"},
    {"circle", "ball sphere"},
    {"pill", "capsule"},
    {"pole bar stick shaft", "rod cylinder"},
    {"disc disk coin puck pipe tube", "cylinder"},
    {"ground terrain floorplane groundplane staticplane surface earth", "floor plane heightfield"},
    {"heightmap landscape hills", "heightfield"},
    {"convex convexhull polyhedron polygon pyramid wedge ramp convexmesh", "hull"},
    {"trimesh model obj trianglemesh stl gltf loadmesh import loadurdf", "mesh"},
    {"chain cable string cord wire tether", "rope"},
    {"fabric sheet curtain flag softbody", "cloth"},
    {"container cup mug pot bowl glass", "bucket"},
    {"boundary bounds walls arena enclosure", "room"},
    {"zone volume field forcefield area effector", "region"},
    {"revolute pivot axle pin hinged revolutejoint door", "hinge"},
    {"prismatic linear piston rail linearjoint sliding", "slider"},
    {"fixed glue attach lock rigid fixedjoint bond fix stick connect", "weld"},
    {"point2point p2p spherical socket ballsocket ballandsocket universal point pointtopoint cone conetwist", "ball_joint"},
    {"rigidrod distancelink constantdistance", "distance"},
    {"damper elastic bungee springdamper dampedspring", "spring"},
    {"suspension vehicle car", "wheel"},
    {"light directionallight sunlight ambientlight", "sun lamp"},
    {"pointlight spotlight bulb light", "lamp sun"},
    {"draw show display screenshot picture image paint renderframe", "render"},
    {"film video movie capture recording output animate writer", "record"},
    {"wind atmosphere drag", "air"},
    {"fluid liquid sea pool", "water"},
    {"thread coroutine async task start startcoroutine", "spawn"},
    {"listen addeventlistener addlistener connect bind callback subscribe", "on"},
    {"unsubscribe disconnect cancel removelistener", "off"},
    {"copy clone backup savestate", "snapshot"},
    {"restorestate reset", "restore"},
    {"load open", "load"},
    {"vector vector3 vec3 v3 vec2 vector2", "vec"},
    {"quaternion rotation euler", "quat"},
    {"simulation scene space engine physicsworld createworld init physics", "world"},
    {"sleep delay pause yield waitforseconds", "wait"},
    {"waituntil waitfor", "wait_until"},
    /* pictures */
    {"target look lookat center centre focus aim", "look_at"},
    {"fieldofview zoom angle", "fov"},
    {"file filename path output out", "to"},
    {"framerate fpsrate rate frequency hz", "fps"},
    {"aa antialiasing msaa supersampling", "samples"},
    {"track attach parent", "follow"},
    /* joints */
    {"body body1 bodya object parenta first obj1 actor0 rigidbody child part holder thing bodies", "a holds"},
    {"other body2 bodyb connectedbody second obj2 actor1 parent to with base target", "b into"},
    {"hingeaxis worldaxis axis1 direction dir normal", "axis along"},
    {"range limit minmax bounds anglelimits lower upper min max lowerlimit upperlimit low high lo hi", "limits"},
    {"k springconstant constant springk kp", "stiffness spring"},
    {"stiffness damping springs", "spring"},
    {"c damper kd dampingcoefficient", "damping spring"},
    {"restlength rest natural naturallength restdistance", "length rest"},
    {"breakforce breakingforce breakthreshold maxforce maximumforce break breaking limitforce", "breaks_at max_force"},
    {"torque maxtorque motortorque maxmotortorque force", "max_torque max_force motor"},
    {"maxspeed enablemotor drive driven actuator", "motor"},
    {"brake", "friction motor"},
    {"collideconnected enablecollision", "collides"},
    {"position value angle", "angle distance"},
    {"pieces count number n links parts", "segments"},
    /* events */
    {"collision collide collided contact contacts collisionstart collisionenter collisionbegin begincontact touch touched hit contactstart "
     "triggerenter contactbegin bump oncollisionenter oncollisionstart ontriggerenter oncollision oncontact onhit", "contact_begin"},
    {"collisionend collisionexit oncollisionexit ontriggerexit endcontact separate separated contactstop contactexit untouch", "contact_end"},
    {"sleep asleep rest stopped", "slept"},
    {"wake awake", "woke"},
    {"break snapped snap destroyed", "broken"},
    {"limit reached", "limit_reached"},
    {"enter regionenter", "entered"},
    {"exit leave", "left"},
    {"position pos location at where contactpoint", "point"},
    {"target othercollider body2 collider hit", "other"},
    {"body me this source object", "self"},
    /* materials */
    {"metal", "steel"}, {"timber oakwood hardwood", "oak"}, {"softwood", "pine"}, {"rock granite marble", "stone"}, {"cement", "concrete"},
    {"aluminum alu", "aluminium"}, {"ceramic", "tile"}, {"styrofoam", "foam"}, {"none", "default"},
};

/* What no one name answers: what is said where `where` is known. */
static const struct { const char *words, *where, *text; } notes[] = {
    {"add create make new insert body object entity actor rigidbody gameobject shape primitive", "floor",
     "things are made by their kind: world:ball{...}, world:box{...}"},
    {"joint constraint link", "hinge", "joints are made by their kind: world:hinge{...}, world:slider{...}, world:weld{...}"},
    {"remove delete destroy kill", "floor", "things remove themselves: body:remove(), joint:remove()"},
    {"update step tick frame everyframe fixedupdate prestep poststep timer time stepped heartbeat", "contact_begin",
     "what is done at every step is a task: world:spawn(function(task) while true do ... task:wait() end end)"},
    {"direction dir at position angle", "shadows", "from = {3, 6, 2} is where its light comes from"},
    {"duration seconds length time", "fps", "a film goes on while the world runs: world:run '3 s'"},
    {"oncontact oncollision ontrigger oncollisionenter ontriggerenter oncollide onhit onstep onupdate", "gravity_scale",
     "events are listened to: body:on('contact_begin', function(e) ... end)"},
    {"active enabled isactive awake", "gravity_scale", "body:disable() takes it out of the world, body:wake() wakes it"},
    {"name mass material id fixed data asleep remove push", "other_dig", "a handler gets an event, with its bodies: e.self, e.other"},
    {"speed velocity pos position", "gravity_scale", "state is set by body:teleport{ at =, velocity =, spin = }"},
};

/* Small letters without '_': "linearVelocity" and "linear_velocity" are the same word. */
static void plain_word(const char *name, char word[WORD])
{
    size_t n = 0;
    for (; *name && n < WORD - 1; name++)
        if (isalnum((unsigned char)*name))
            word[n++] = (char)tolower((unsigned char)*name);
    word[n] = '\0';
}

static bool has_word(const char *words, const char *word)
{
    size_t length = strlen(word);
    for (const char *p = words; length > 0 && (p = strstr(p, word)) != NULL; p += length)
        if ((p == words || p[-1] == ' ') && (p[length] == ' ' || p[length] == '\0'))
            return true;
    return false;
}

/* The first of the words in `answers` that is a name here. */
static const char *first_known(const char *answers, const char *const *names, int count)
{
    while (*answers) {
        size_t length = strcspn(answers, " ");
        for (int i = 0; i < count; i++)
            if (strlen(names[i]) == length && strncmp(names[i], answers, length) == 0)
                return names[i];
        answers += length;
        answers += *answers == ' ';
    }
    return NULL;
}

static const char *known_as(const char *word, const char *const *names, int count)
{
    char other[WORD];
    for (int i = 0; i < count; i++) {
        plain_word(names[i], other);
        if (names[i][0] != '_' && strcmp(other, word) == 0)
            return names[i];
    }
    for (size_t i = 0; i < sizeof meanings / sizeof *meanings; i++) {
        const char *found = has_word(meanings[i].words, word) ? first_known(meanings[i].answers, names, count) : NULL;
        if (found)
            return found;
    }
    return NULL;
}

/* setPosition, create_box, isStatic; RevoluteJoint, box_shape: the word without what others put before and behind it. */
static bool strip(char word[WORD])
{
    static const char *const before[] = {"set", "get", "add", "create", "make", "new", "apply", "is", "do", "rigid", "b2", "mj", NULL};
    static const char *const behind[] = {"joint", "constraint", "body", "shape", "geometry", "collider", "object", "vector", "3d", "mesh", "event", NULL};
    size_t length = strlen(word);
    for (int i = 0; before[i]; i++) {
        size_t n = strlen(before[i]);
        if (length > n + 1 && strncmp(word, before[i], n) == 0) {
            memmove(word, word + n, length - n + 1);
            return true;
        }
    }
    for (int i = 0; behind[i]; i++) {
        size_t n = strlen(behind[i]);
        if (length > n + 1 && strcmp(word + length - n, behind[i]) == 0) {
            word[length - n] = '\0';
            return true;
        }
    }
    return false;
}

const char *bind_mean(const char *name, const char *const *names, int count)
{
    char word[WORD];
    plain_word(name, word);
    const char *found = known_as(word, names, count);
    while (!found && strip(word))
        found = known_as(word, names, count);
    return found;
}

const char *bind_mean_note(const char *name, const char *const *names, int count)
{
    char word[WORD];
    plain_word(name, word);
    do {
        for (size_t i = 0; i < sizeof notes / sizeof *notes; i++)
            if (has_word(notes[i].words, word) && first_known(notes[i].where, names, count))
                return notes[i].text;
    } while (strip(word));
    return NULL;
}

/* ---- how a function is called ------------------------------------------------------------------ */

static const struct { const char *what, *fields; } examples[] = {
    {"digbox.world", "gravity = {0, -9.81, 0}"},
    {"world:ball", "radius = 0.1, at = {0, 1, 0}"}, {"world:sphere", "radius = 0.1, at = {0, 1, 0}"},
    {"world:box", "size = {1, 0.2, 0.5}, at = {0, 1, 0}"}, {"world:capsule", "radius = 0.1, length = 0.3, at = {0, 1, 0}"},
    {"world:cylinder", "radius = 0.1, height = 0.3, at = {0, 1, 0}"}, {"world:cone", "radius = 0.1, height = 0.3, at = {0, 1, 0}"},
    {"world:rod", "length = 0.4, radius = 0.01, at = {0, 1, 0}"}, {"world:hull", "points = {{0, 0, 0}, ...}, at = {0, 1, 0}"},
    {"world:body", "parts = {digbox.box{...}, ...}, at = {0, 1, 0}"}, {"world:room", "size = {4, 3, 4}"},
    {"world:floor", "material = 'tile'"}, {"world:plane", "normal = {0, 1, 0}"},
    {"digbox.ball", "radius = 0.1"}, {"digbox.sphere", "radius = 0.1"}, {"digbox.box", "size = {1, 0.2, 0.5}"},
    {"digbox.capsule", "radius = 0.1, length = 0.3"}, {"digbox.cylinder", "radius = 0.1, height = 0.3"},
    {"world:hinge", "a = door, b = frame, at = {0, 1, 0}, axis = {0, 1, 0}"}, {"world:slider", "a = drawer, b = chest, along = {0, 0, 1}"},
    {"world:ball_joint", "a = arm, b = trunk, at = {0, 1, 0}"}, {"world:weld", "a = part, b = other"},
    {"world:distance", "a = ball, b = other, length = 0.5"}, {"world:spring", "a = ball, b = other, stiffness = 100"},
    {"world:rope", "a = ball, at = {0, 2, 0}, length = 1"}, {"world:wheel", "a = wheel, b = car, at = {0, 0.3, 0}"},
    {"world:motor", "a = wheel, b = car, along = {1, 0, 0}, speed = 3"}, {"world:gear", "a = hinge, b = other, ratio = {1, 2}"},
    {"body:push", "force = {0, 0, 5}"}, {"body:hit", "impulse = {0, 0, 1}"}, {"body:twist", "torque = {0, 1, 0}"},
    {"body:teleport", "at = {0, 1, 0}"}, {"body:move_to", "at = {0, 1, 0}, over = 2"}, {"body:can_move", "along = {1, 0, 0}, with = 30"},
    {"world:camera", "at = {1, 1, 2}, look_at = ball"}, {"world:record", "to = 'film.mp4'"}, {"world:render", "to = 'picture.png'"},
    {"world:sun", "from = {3, 6, 2}"}, {"world:lamp", "at = {0, 3, 0}"}, {"world:run", "seconds = 3"},
    {"world:ray", "from = {0, 3, 0}, to = {0, 0, 0}"}, {"joint:set", "motor = {speed = 3}"},
};

const char *bind_example(lua_State *L, const char *what)
{
    for (size_t i = 0; i < sizeof examples / sizeof *examples; i++)
        if (strcmp(examples[i].what, what) == 0)
            return lua_pushfstring(L, "%s{ %s }", what, examples[i].fields);
    return lua_pushstring(L, "");
}

int bind_wants_fields(lua_State *L, int index, const char *what)
{
    index = lua_absindex(L, index);
    const char *got = luaL_getmetafield(L, index, "__name") == LUA_TSTRING ? lua_tostring(L, -1) : luaL_typename(L, index);
    const char *example = bind_example(L, what);
    return bind_error(L, "%s wants a table of fields; got %s%s%s%s", what, got, *example ? " (write " : "", example, *example ? ")" : "");
}

/* core.wants_fields(value, what) raises it */
static int mean_wants_fields(lua_State *L)
{
    return bind_wants_fields(L, 1, luaL_checkstring(L, 2));
}

void bind_mean_open(lua_State *L, int core)
{
    lua_pushcfunction(L, mean_wants_fields);
    lua_setfield(L, core, "wants_fields");
}
