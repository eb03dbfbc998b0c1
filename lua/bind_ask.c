/* lua/bind_ask.c - exploratory questions: body:can_move{...} and world:ask{...}. Asking changes nothing. */

#include "bind.h"

#include <math.h>

/* A body, a joint, or the name of a wall of the room. */
static void push_part(lua_State *L, int world, dig_part p)
{
    if (p.joint.gen)
        bind_push_joint(L, world, p.joint);
    else if (p.wall)
        lua_pushstring(L, dig_wall_name(p.wall));
    else
        bind_push_body(L, world, p.body);
}

static void set_parts(lua_State *L, int world, const char *name, const dig_part *parts, int count)
{
    bind_push_list(L, count);
    for (int i = 0; i < count; i++) {
        push_part(L, world, parts[i]);
        lua_rawseti(L, -2, i + 1);
    }
    lua_setfield(L, -2, name);
}

static void set_consequences(lua_State *L, int world, const dig_answer *a)
{
    bind_push_list(L, a->consequence_count);
    for (int i = 0; i < a->consequence_count; i++) {
        const dig_consequence *c = &a->consequences[i];
        lua_newtable(L);
        bind_set_text(L, "what", c->what);
        push_part(L, world, c->who);
        lua_setfield(L, -2, "who");
        bind_set_real(L, "amount", c->amount);
        lua_rawseti(L, -2, i + 1);
    }
    lua_setfield(L, -2, "consequences");
}

static const char *const sometimes[] = {"needs", "held_by", "blocked_by", NULL};

static int push_answer(lua_State *L, int world, const dig_answer *a)
{
    lua_newtable(L);
    bind_set_text(L, "verdict", dig_verdict_name(a->verdict));
    bind_set_bool(L, "ok", a->ok);
    if (!isnan(a->needs))
        bind_set_real(L, "needs", a->needs);
    bind_set_real(L, "moved", a->moved);
    bind_set_real(L, "time", a->time);
    if (a->held_count > 0) {
        push_part(L, world, a->held[0]);
        lua_setfield(L, -2, "held_by");
        push_part(L, world, a->held[0]);
        lua_setfield(L, -2, "blocked_by");
    }
    set_parts(L, world, "holders", a->held, a->held_count);
    set_parts(L, world, "chain", a->chain, a->chain_count);
    set_consequences(L, world, a);
    bind_set_int(L, "trials", a->trials);
    bind_set_int(L, "steps", a->steps);
    bind_set_text(L, "because", a->because);
    bind_record(L, "answer", sometimes, false);
    return 1;
}

/* The question in the table at 2. */
static void read_question(lua_State *L, const char *what, dig_question *q)
{
    q->turns = bind_get_vec3(L, 2, what, "turn", "1", &q->along);
    if (q->turns && bind_own_field(L, 2, "along") != LUA_TNIL)
        bind_error(L, "%s: turn and along exclude each other", what);
    if (!q->turns && !bind_get_vec3(L, 2, what, "along", "1", &q->along))
        bind_error(L, "%s: along is missing (a direction, or turn = axis)", what);
    bool by = bind_get_real(L, 2, what, "by", q->turns ? "rad" : "m", &q->by);
    if (q->turns && !by)
        q->by = 0.01;
    if (q->turns && by) {
        bind_own_field(L, 2, "by");
        bind_refuse_degrees(L, -1, what, "by");
        lua_pop(L, 1);
    }
    bind_get_real(L, 2, what, "with", q->turns ? "N*m" : "N", &q->with);
    q->has_at = bind_get_vec3(L, 2, what, "at", "m", &q->at);
    bind_get_real(L, 2, what, "within", "s", &q->within);
}

/* body:can_move{along = {x, y, z}, by =, with =, at =, within =} or {turn = axis, ...} -> answer
 * along  {x,y,z}          which way, world axes; turn: about which axis, through the centre of mass
 * by                m     or rad: how far; default 1 cm
 * with              N     or N m: how hard; default: answer how much it needs
 * at     {x,y,z}    m     where it is pushed; default: the centre of mass
 * within            s     how long at most; default 5 s
 */
static int body_can_move(lua_State *L)
{
    BodyRef *b = bind_check_body(L, 1);
    dig_question q = dig_question_defaults();
    dig_answer a;
    bind_arguments(L, 2, "body:can_move");
    read_question(L, "body:can_move", &q);
    q.body = b->id;
    dig_status s = dig_ask(b->world->w, &q, &a);
    bind_own_check(L, b->world);
    if (s != DIG_OK)
        return bind_fail(L, b->world->w, s);
    bind_push_world_of(L, 1);
    return push_answer(L, lua_gettop(L), &a);
}

/* world:ask{body =, along =, ...} -> answer; as body:can_move */
static int world_ask(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    dig_question q = dig_question_defaults();
    dig_answer a;
    bind_arguments(L, 2, "world:ask");
    if (bind_own_field(L, 2, "body") == LUA_TNIL)
        return bind_error(L, "world:ask: body is missing (who is to move?)");
    q.body = bind_body_of(L, lua_gettop(L), ref)->id;
    read_question(L, "world:ask", &q);
    dig_status s = dig_ask(ref->w, &q, &a);
    bind_own_check(L, ref);
    return s == DIG_OK ? push_answer(L, 1, &a) : bind_fail(L, ref->w, s);
}

void bind_ask_open(lua_State *L, int core)
{
    static const luaL_Reg of_body[] = {{"can_move", body_can_move}, {NULL, NULL}};
    static const luaL_Reg of_world[] = {{"ask", world_ask}, {NULL, NULL}};
    bind_extend(L, core, BIND_BODY, of_body);
    bind_extend(L, core, BIND_WORLD, of_world);
}
