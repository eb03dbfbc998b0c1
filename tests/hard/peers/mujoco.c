/* tests/hard/peers/mujoco.c - driver of MuJoCo (Debian's libmujoco-dev) for the hard cases.
 *
 * Scenes are turned to have z up. Its own defaults: Euler, Newton, pyramidal cone, and its time step of 2 ms, taken as 1/480 s (or
 * the next smaller part of the frame). Jointed bodies are joints of its tree, which cannot come apart; joints that close a loop are
 * its soft equalities, a hinge two of them. MuJoCo has no restitution: contacts of a scene with one are springs and dampers, eight
 * steps long, with that ratio of speeds. What is driven is a body of 1e9 kg on joints whose speed is set before each step.
 */
#include <math.h>
#include <mujoco/mujoco.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "peer.h"

enum { MOST_BODIES = 2200, RATE = 480, MOST_DEPTH = 80 };       /* its reader takes elements 100 deep */

const char *const peer_name = "mujoco";

struct Peer {
    const PeerScene *given;
    PeerScene       *scene;                     /* the same with z up, bodies' own axes as well, as MuJoCo's users have it */
    mjModel         *model;
    mjData          *data;
    int             *id, *of_geom;              /* MuJoCo's body of each; body of each geometry */
    int             *first, *depth;             /* the joint that holds a body in the tree, and how deep */
    double         (*push)[3];                  /* N, in the first part of the next frame */
    bool             pushed, line_closes;       /* a slider closes a loop: no equality says so */
    int              parts;                     /* of a frame */
    char            *text;
    size_t           used, room;
};

__attribute__((format(printf, 2, 3))) static void put(Peer *p, const char *format, ...)
{
    if (p->room - p->used < 4096) {
        p->room = p->room ? 2 * p->room : 1 << 20;
        p->text = realloc(p->text, p->room);
        if (!p->text)
            abort();
    }
    va_list list;
    va_start(list, format);
    int n = vsnprintf(p->text + p->used, p->room - p->used, format, list);
    va_end(list);
    p->used += n > 0 ? (size_t)n : 0;
}

/* ---- y up to z up and back ---- */

static void z_up(double v[3])
{
    double y = v[1];
    v[1] = -v[2];
    v[2] = y;
}

static void y_up(double v[3])
{
    double z = v[2];
    v[2] = -v[1];
    v[1] = z;
}

static void state_z_up(PeerState *s)
{
    z_up(s->at);
    z_up(s->turn + 1);
    z_up(s->v);
    z_up(s->spin);
}

static void *array(int count, size_t size)
{
    void *list = calloc((size_t)count + 1, size);
    if (!list)
        abort();
    return list;
}

static void body_z_up(PeerBody *b)
{
    z_up(b->size);
    if (b->kind == PEER_BOX)
        b->size[1] = -b->size[1];               /* half edges have no sign */
    if (b->kind == PEER_CYLINDER)
        b->size[1] = b->size[2], b->size[2] = 0;
    z_up(b->inertia);
    b->inertia[1] = -b->inertia[1];
    state_z_up(&b->start);
    if (!b->hull)
        return;
    PeerHull *turned = array(0, sizeof *turned);
    *turned = *b->hull;
    for (int k = 0; k < turned->points; k++)
        z_up(turned->point[k]);
    b->hull = turned;
}

static PeerScene *scene_z_up(const PeerScene *given)
{
    PeerScene *s = array(0, sizeof *s);
    *s = *given;
    z_up(s->gravity);
    s->body = array(s->bodies, sizeof *s->body);
    s->joint = array(s->joints, sizeof *s->joint);
    for (int i = 0; i < s->bodies; i++) {
        s->body[i] = given->body[i];
        body_z_up(&s->body[i]);
    }
    for (int i = 0; i < s->joints; i++) {
        PeerJoint *j = &s->joint[i];
        *j = given->joint[i];
        z_up(j->axis);
        for (int end = 0; end < 2; end++) {
            z_up(j->at[end]);
            z_up(j->local[end]);
            z_up(j->local_axis[end]);
        }
    }
    return s;
}

/* ---- the scene as text ---- */

static void put_geom(Peer *p, int i)
{
    const PeerBody *b = &p->scene->body[i];
    const double *s = b->size;
    const bool still = b->mass <= 0 && !b->driven;
    double turn[4] = {1, 0, 0, 0}, at[3] = {0};
    int touches = b->ghost ? 0 : 1 << (b->group % 30), with = b->ghost ? 0 : b->group ? ~touches & 0x3fffffff : 0x3fffffff;
    put(p, "<geom name='g%d' contype='%d' conaffinity='%d' friction='%.17g 0 %.17g'", i, touches, with, b->friction, b->rolling);
    if (b->rolling > 0)
        put(p, " condim='6'");
    if (still) {
        memcpy(turn, b->start.turn, sizeof turn);
        memcpy(at, b->start.at, sizeof at);
    }
    if (b->kind == PEER_SPHERE) {
        put(p, " type='sphere' size='%.17g'", s[0]);
    } else if (b->kind == PEER_BOX) {
        put(p, " type='box' size='%.17g %.17g %.17g'", s[0], s[1], s[2]);
    } else if (b->kind == PEER_HULL) {
        put(p, " type='mesh' mesh='h%d'", i);
    } else if (b->kind == PEER_CYLINDER) {      /* a disc that is driven is a square table, whose contacts are exact */
        if (b->driven)
            put(p, " type='box' size='%.17g %.17g %.17g'", s[0], s[0], s[1]);
        else
            put(p, " type='cylinder' size='%.17g %.17g'", s[0], s[1]);
    } else {
        put(p, " type='plane' size='50 50 1'");
        mju_quatZ2Vec(turn, s);
        for (int k = 0; k < 3; k++)
            at[k] = s[k] * b->offset;
    }
    put(p, " pos='%.17g %.17g %.17g' quat='%.17g %.17g %.17g %.17g'/>\n", at[0], at[1], at[2], turn[0], turn[1], turn[2], turn[3]);
}

/* A motor that holds still is dry friction, which MuJoCo has as such. */
static bool rubs(const PeerJoint *j) { return j->motor_torque > 0 && j->motor_speed == 0; }

static void put_tree_joint(Peer *p, int i)
{
    const PeerJoint *j = &p->scene->joint[p->first[i]];
    const PeerState *s = &p->scene->body[i].start;
    const int end = j->a == i ? 0 : 1;
    double arm[3], at[3], axis[3];
    for (int k = 0; k < 3; k++)
        arm[k] = j->at[end][k] - s->at[k];
    peer_turned_back(s->turn, arm, at);
    peer_turned_back(s->turn, j->axis, axis);
    put(p, "<joint name='j%d' type='%s' pos='%.17g %.17g %.17g'", p->first[i], j->kind == PEER_BALL ? "ball" :
        j->kind == PEER_HINGE ? "hinge" : "slide", at[0], at[1], at[2]);
    if (j->kind != PEER_BALL)
        put(p, " axis='%.17g %.17g %.17g'", axis[0], axis[1], axis[2]);
    if (j->limited)
        put(p, " limited='true' range='%.17g %.17g'", j->lower, j->upper);
    if (rubs(j))
        put(p, " frictionloss='%.17g'", j->motor_torque);
    put(p, "/>\n");
}

static int parent_of(const Peer *p, int i)
{
    const PeerJoint *j = &p->scene->joint[p->first[i]];
    return j->a == i ? j->b : j->a;
}

/* A body with the bodies that hang on it inside: places are relative to the parent. */
static void put_body(Peer *p, int i, const PeerState *parent)
{
    const PeerBody *b = &p->scene->body[i];
    double arm[3], at[3], back[4], turn[4];
    for (int k = 0; k < 3; k++)
        arm[k] = b->start.at[k] - parent->at[k];
    peer_turned_back(parent->turn, arm, at);
    mju_negQuat(back, parent->turn);
    mju_mulQuat(turn, back, b->start.turn);
    put(p, "<body name='b%d' pos='%.17g %.17g %.17g' quat='%.17g %.17g %.17g %.17g'>\n", i, at[0], at[1], at[2], turn[0], turn[1], turn[2],
        turn[3]);
    if (b->driven)
        put(p, "<joint type='slide' axis='1 0 0'/><joint type='hinge' axis='0 0 1'/><inertial pos='0 0 0' mass='1e9' "
            "diaginertia='1e9 1e9 1e9'/>");
    else if (p->first[i] < 0)
        put(p, "<freejoint/>");
    else
        put_tree_joint(p, i);
    if (!b->driven)
        put(p, "<inertial pos='0 0 0' mass='%.17g' diaginertia='%.17g %.17g %.17g'/>", b->mass, b->inertia[0], b->inertia[1],
            b->inertia[2]);
    put_geom(p, i);
    for (int k = 0; k < p->scene->joints; k++) {
        const PeerJoint *j = &p->scene->joint[k];
        for (int end = 0; end < 2 && j->kind == PEER_SPRING; end++)
            if ((end ? j->b : j->a) == i)
                put(p, "<site name='s%d%c' pos='%.17g %.17g %.17g'/>\n", k, end ? 'b' : 'a', j->local[end][0], j->local[end][1],
                    j->local[end][2]);
    }
    for (int k = 0; k < p->scene->bodies; k++)
        if (p->first[k] >= 0 && parent_of(p, k) == i)
            put_body(p, k, &b->start);
    put(p, "</body>\n");
}

/* Hangs one more body on a joint to what is placed. Sliders come first: an equality that closes a loop holds points, not lines. */
static bool hang_one(Peer *p, bool *placed, bool *used, bool sliders)
{
    for (int k = 0; k < p->scene->joints; k++) {
        const PeerJoint *j = &p->scene->joint[k];
        const bool a = placed[j->a], b = j->b < 0 || placed[j->b];
        if (used[k] || j->kind == PEER_SPRING || (j->kind == PEER_SLIDER) != sliders || a == b)
            continue;
        const int child = a ? j->b : j->a, parent = a ? j->a : j->b;
        p->depth[child] = parent < 0 ? 1 : p->depth[parent] + 1;
        if (p->depth[child] > MOST_DEPTH)
            continue;
        p->first[child] = k;
        placed[child] = used[k] = true;
        return true;
    }
    return false;
}

/* Trees of all that is joined: each body hangs on the first joint that reaches it, from the world or from a body that floats. One that
 * would hang too deep floats, and an equality holds it. */
static void make_tree(Peer *p, bool *closes)
{
    const PeerScene *s = p->scene;
    bool *placed = calloc((size_t)s->bodies + 1, sizeof *placed), *used = calloc((size_t)s->joints + 1, sizeof *used);
    if (!placed || !used)
        abort();
    for (int i = 0; i < s->bodies; i++) {
        p->first[i] = -1;
        placed[i] = s->body[i].mass <= 0;
    }
    for (int root = -1; root < s->bodies; root++) {
        if (root >= 0 && placed[root])
            continue;
        if (root >= 0)
            placed[root] = true, p->depth[root] = 0;
        while (hang_one(p, placed, used, true) || hang_one(p, placed, used, false)) {
        }
    }
    for (int k = 0; k < s->joints; k++)
        closes[k] = !used[k] && s->joint[k].kind != PEER_SPRING;
    free(placed);
    free(used);
}

/* Of a joint that closes a loop: its point, and for a hinge a second one along the axis. */
static void put_closing(Peer *p, const PeerJoint *j)
{
    p->line_closes = p->line_closes || j->kind == PEER_SLIDER;
    for (int k = 0; k < (j->kind == PEER_BALL ? 1 : 2); k++) {
        double at[3];
        for (int c = 0; c < 3; c++)
            at[c] = j->local[0][c] + (j->kind == PEER_BALL ? 0 : (k ? 0.25 : -0.25) * j->local_axis[0][c]);
        put(p, "<connect body1='b%d'", j->a);
        if (j->b >= 0)
            put(p, " body2='b%d'", j->b);
        put(p, " anchor='%.17g %.17g %.17g'/>\n", at[0], at[1], at[2]);
    }
}

static void put_joints(Peer *p, const bool *closes)
{
    const PeerScene *s = p->scene;
    put(p, "<equality>\n");
    for (int k = 0; k < s->joints; k++)
        if (closes[k])
            put_closing(p, &s->joint[k]);
    put(p, "</equality><tendon>\n");
    for (int k = 0; k < s->joints; k++)
        if (s->joint[k].kind == PEER_SPRING)
            put(p, "<spatial stiffness='%.17g' damping='%.17g' springlength='%.17g'><site site='s%da'/><site site='s%db'/></spatial>\n",
                s->joint[k].stiffness, s->joint[k].damping, s->joint[k].length, k, k);
    put(p, "</tendon><actuator>\n");
    for (int k = 0; k < s->joints; k++)
        if (s->joint[k].motor_torque > 0 && !rubs(&s->joint[k]) && !closes[k])
            put(p, "<velocity joint='j%d' kv='%.17g' forcelimited='true' forcerange='%.17g %.17g'/>\n", k,
                2 * s->joint[k].motor_torque / fabs(s->joint[k].motor_speed), -s->joint[k].motor_torque, s->joint[k].motor_torque);
    put(p, "</actuator>\n");
}

/* MuJoCo takes the larger friction of a pair. Where that is not the geometric mean, the pair is named with its own. */
static void put_pairs(Peer *p, const char *reference)
{
    const PeerScene *s = p->scene;
    put(p, "<contact>\n");
    for (int i = 0; i < s->bodies; i++)
        for (int k = 0; k < s->bodies; k++) {
            const PeerBody *plane = &s->body[i], *b = &s->body[k];
            double mu = sqrt(plane->friction * b->friction);
            if (plane->kind == PEER_PLANE && b->mass > 0 && fabs(plane->friction - b->friction) > 1e-9)
                put(p, "<pair geom1='g%d' geom2='g%d' condim='3' friction='%.17g %.17g 0 0 0' %s/>\n", i, k, mu, mu, reference);
        }
    for (int k = 0; k < s->joints; k++) {
        const PeerJoint *j = &s->joint[k];
        if (j->b >= 0 && s->body[j->b].mass > 0 && s->body[j->a].mass > 0 && j->kind != PEER_SPRING)
            put(p, "<exclude body1='b%d' body2='b%d'/>\n", j->a, j->b);
    }
    put(p, "</contact>\n");
}

static bool mixed_friction(const PeerScene *s)
{
    for (int i = 0; i < s->bodies; i++)
        for (int k = 0; k < s->bodies; k++)
            if (s->body[i].kind == PEER_PLANE && s->body[k].mass > 0 && fabs(s->body[i].friction - s->body[k].friction) > 1e-9)
                return true;
    return false;
}

static void put_head(Peer *p, char *reference, size_t room)
{
    const PeerScene *s = p->scene;
    double h = s->step / p->parts, e = fmin(s->restitution, 0.999999);
    long contacts = s->bodies < 150 ? 12L * s->bodies + 200 : 4L * s->bodies + 400, rows = 4 * contacts + 6L * s->joints + 400;
    put(p, "<mujoco><compiler angle='radian' boundmass='0' boundinertia='0'/>");
    put(p, "<size nconmax='%ld' njmax='%ld' nstack='%ld'/>", contacts, rows, 2000L * 1048576 / 8);
    put(p, "<option timestep='%.17g' gravity='%.17g %.17g %.17g'/>\n", h, s->gravity[0], s->gravity[1], s->gravity[2]);
    reference[0] = '\0';
    if (e > 0) {
        double pi = acos(-1), ratio = -log(e) / sqrt(pi * pi + log(e) * log(e)), omega = pi / (8 * h);
        snprintf(reference, room, "solref='%.17g %.17g' solimp='0.9999 0.9999 0.001'", -omega * omega, -2 * ratio * omega);
    }
    bool smooth = true;
    for (int i = 0; i < s->bodies; i++)
        smooth = smooth && s->body[i].friction <= 0;
    put(p, "<default><geom condim='%d' %s/></default>\n<asset>", smooth ? 1 : 3, reference);
    for (int i = 0; i < s->bodies; i++) {
        if (s->body[i].kind != PEER_HULL)
            continue;
        put(p, "<mesh name='h%d' vertex='", i);
        for (int k = 0; k < s->body[i].hull->points; k++)
            put(p, "%.17g %.17g %.17g ", s->body[i].hull->point[k][0], s->body[i].hull->point[k][1], s->body[i].hull->point[k][2]);
        put(p, "'/>\n");
    }
    put(p, "</asset>\n");
}

static void put_scene(Peer *p)
{
    const PeerScene *s = p->scene;
    const PeerState world = {.turn = {1, 0, 0, 0}};
    bool *closes = calloc((size_t)s->joints + 1, sizeof *closes);
    char reference[160];
    if (!closes)
        abort();
    make_tree(p, closes);
    put_head(p, reference, sizeof reference);
    put(p, "<worldbody>\n");
    for (int i = 0; i < s->bodies; i++)
        if (s->body[i].gone)
            continue;
        else if (s->body[i].mass <= 0 && !s->body[i].driven)
            put_geom(p, i);
        else if (p->first[i] < 0 || parent_of(p, i) < 0 || s->body[parent_of(p, i)].mass <= 0)
            put_body(p, i, &world);
    for (int k = 0; k < s->joints; k++)
        if (s->joint[k].kind == PEER_SPRING && s->joint[k].b < 0)
            put(p, "<site name='s%db' pos='%.17g %.17g %.17g'/>\n", k, s->joint[k].at[1][0], s->joint[k].at[1][1], s->joint[k].at[1][2]);
    put(p, "</worldbody>\n");
    put_joints(p, closes);
    if (mixed_friction(s) || s->joints)
        put_pairs(p, reference);
    put(p, "</mujoco>");
    free(closes);
}

/* MuJoCo would write a log file into the current folder; its warnings are counted in its data anyway. */
static void hear_warning(const char *text) { (void)text; }

static void hear_error(const char *text)
{
    fprintf(stderr, "mujoco: %s\n", text);
    exit(77);
}

/* Speeds of the joints from those of the bodies. */
static void set_speeds(Peer *p)
{
    for (int i = 0; i < p->scene->bodies; i++) {
        const PeerBody *b = &p->scene->body[i];
        if (p->id[i] < 0 || b->driven)
            continue;
        const int joint = p->model->body_jntadr[p->id[i]], type = p->model->jnt_type[joint];
        double *speed = p->data->qvel + p->model->jnt_dofadr[joint], relative[3];
        memcpy(relative, b->start.spin, sizeof relative);
        if (type == mjJNT_FREE) {
            memcpy(speed, b->start.v, sizeof b->start.v);
            peer_turned_back(b->start.turn, b->start.spin, speed + 3);       /* MuJoCo has it in body axes */
            continue;
        }
        const PeerJoint *j = &p->scene->joint[p->first[i]];
        const int parent = parent_of(p, i);
        for (int k = 0; k < 3 && parent >= 0; k++)
            relative[k] -= p->scene->body[parent].start.spin[k];
        if (type == mjJNT_BALL)
            peer_turned_back(b->start.turn, relative, speed);
        else if (type == mjJNT_HINGE)
            speed[0] = mju_dot3(relative, j->axis);
        else
            speed[0] = mju_dot3(b->start.v, j->axis) - (parent >= 0 ? mju_dot3(p->scene->body[parent].start.v, j->axis) : 0);
    }
}

static bool load(Peer *p, char *why, size_t room)
{
    mjVFS *files = calloc(1, sizeof *files);
    if (!files)
        abort();
    mj_defaultVFS(files);
    mj_makeEmptyFileVFS(files, "scene.xml", (int)p->used);
    memcpy(files->filedata[0], p->text, p->used);
    p->model = mj_loadXML("scene.xml", files, why, (int)room);
    mj_deleteVFS(files);
    free(files);
    free(p->text);
    p->text = NULL;
    p->data = p->model ? mj_makeData(p->model) : NULL;
    if (!p->data && (p->model || strstr(why, "mjData")))
        snprintf(why, room, "its matrices for %d bodies are over its limit of 2 GiB", p->scene->bodies);
    return p->data;
}

Peer *peer_open(const PeerScene *scene, char *why, size_t room)
{
    if (scene->bodies > MOST_BODIES) {
        snprintf(why, room, "over %d bodies: its memory grows with their square", MOST_BODIES);
        return NULL;
    }
    mju_user_warning = hear_warning;
    mju_user_error = hear_error;
    Peer *p = array(0, sizeof *p);
    p->given = scene;
    p->scene = scene_z_up(scene);
    p->parts = (int)ceil(scene->step * RATE - 1e-6);
    p->id = array(scene->bodies, sizeof(int));
    p->first = array(scene->bodies, sizeof(int));
    p->depth = array(scene->bodies, sizeof(int));
    p->push = array(scene->bodies, sizeof *p->push);
    put_scene(p);
    bool expressed = !p->line_closes;
    if (!expressed)
        snprintf(why, room, "no equality for a slider that closes a loop");
    if (!expressed || !load(p, why, room)) {
        peer_close(p);
        return NULL;
    }
    p->of_geom = array((int)p->model->ngeom, sizeof(int));
    for (int i = 0; i < scene->bodies; i++) {
        char name[24];
        snprintf(name, sizeof name, "b%d", i);
        p->id[i] = mj_name2id(p->model, mjOBJ_BODY, name);
        name[0] = 'g';
        int geom = mj_name2id(p->model, mjOBJ_GEOM, name);
        if (geom >= 0)
            p->of_geom[geom] = i;
    }
    for (int u = 0, k = 0; k < scene->joints && u < p->model->nu; k++)
        if (scene->joint[k].motor_torque > 0 && !rubs(&scene->joint[k]))
            p->data->ctrl[u++] = scene->joint[k].motor_speed;
    set_speeds(p);
    mj_forward(p->model, p->data);
    return p;
}

static void set_movers(Peer *p)
{
    for (int i = 0; i < p->scene->bodies; i++)
        if (p->scene->body[i].driven && p->id[i] >= 0) {
            double *speed = p->data->qvel + p->model->body_dofadr[p->id[i]];
            speed[0] = p->given->body[i].drive[0][0];
            speed[1] = p->given->body[i].drive[1][1];
        }
}

static void set_pushes(Peer *p)
{
    const double none[3] = {0}, h = p->scene->step / p->parts;
    mju_zero(p->data->qfrc_applied, p->model->nv);
    for (int i = 0; i < p->scene->bodies && p->pushed; i++) {
        double force[3] = {p->push[i][0] / h, p->push[i][1] / h, p->push[i][2] / h};
        if (p->id[i] > 0)
            mj_applyFT(p->model, p->data, force, none, p->data->xipos + 3 * p->id[i], p->id[i], p->data->qfrc_applied);
        memset(p->push[i], 0, sizeof p->push[i]);
    }
}

void peer_step(Peer *p)
{
    for (int part = 0; part < p->parts; part++) {
        set_movers(p);
        if (p->pushed) {
            set_pushes(p);
            p->pushed = part == 0;
        }
        mj_step(p->model, p->data);
    }
}

void peer_states(Peer *p, PeerState *out)
{
    bool lost = false;
    for (int w = mjWARN_BADQPOS; w <= mjWARN_BADQACC; w++)
        lost = lost || p->data->warning[w].number > 0;
    mj_kinematics(p->model, p->data);                     /* mj_step leaves places of the step before */
    mj_comPos(p->model, p->data);
    mj_comVel(p->model, p->data);
    for (int i = 0; i < p->scene->bodies; i++) {
        double six[6];
        const int id = p->id[i];
        if (id <= 0)
            continue;
        mj_objectVelocity(p->model, p->data, mjOBJ_BODY, id, six, 0);
        memcpy(out[i].at, p->data->xipos + 3 * id, sizeof out[i].at);
        memcpy(out[i].turn, p->data->xquat + 4 * id, sizeof out[i].turn);
        memcpy(out[i].spin, six, sizeof out[i].spin);
        memcpy(out[i].v, six + 3, sizeof out[i].v);
        y_up(out[i].at);
        y_up(out[i].turn + 1);
        y_up(out[i].v);
        y_up(out[i].spin);
        if (lost)                       /* MuJoCo starts anew when its state is lost: what follows is not this motion */
            out[i].at[0] = NAN;
    }
}

void peer_push(Peer *p, int body, const double impulse[3])
{
    double turned[3] = {impulse[0], impulse[1], impulse[2]};
    z_up(turned);
    for (int k = 0; k < 3; k++)
        p->push[body][k] += turned[k];
    p->pushed = true;
}

bool peer_joint_force(Peer *p, int joint, double force[3])
{
    (void)p, (void)joint, (void)force;
    return false;
}

int peer_touches(Peer *p, PeerTouch *out, int room)
{
    int n = p->data->ncon < room ? p->data->ncon : room;
    for (int c = 0; c < n; c++) {
        double force[6];
        const mjContact *contact = &p->data->contact[c];
        mj_contactForce(p->model, p->data, c, force);
        out[c] = (PeerTouch){.a = p->of_geom[contact->geom1], .b = p->of_geom[contact->geom2]};
        mju_mulMatTVec(out[c].force, contact->frame, force, 3, 3);
        y_up(out[c].force);
    }
    return n;
}

void peer_close(Peer *p)
{
    if (p->data)
        mj_deleteData(p->data);
    if (p->model)
        mj_deleteModel(p->model);
    for (int i = 0; i < p->scene->bodies; i++)
        free(p->scene->body[i].hull);
    free(p->scene->body);
    free(p->scene->joint);
    free(p->scene);
    free(p->id);
    free(p->of_geom);
    free(p->first);
    free(p->depth);
    free(p->push);
    free(p->text);
    free(p);
}
