/* tests/peers/mujoco.c - driver of MuJoCo (Debian's libmujoco-dev).
 *
 * The default is MuJoCo's own time step of 2 ms, taken as 480 Hz so that it meets the frame times; its ladder goes both
 * ways from there. Variants: Euler with a pyramidal cone as it comes; RK4; and an elliptic cone with contacts as stiff
 * as the step allows. Jointed bodies are joints of its tree, so that they cannot come apart. MuJoCo has no restitution:
 * where a scene has one, contacts are springs and dampers with the exact ratio of speeds, eight steps long.
 * Movers are bodies of 1e9 kg on a joint whose speed is set before each step.
 */
#include <math.h>
#include <mujoco/mujoco.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "peer.h"

enum { EULER, RK4, STIFF };

const char *const peer_name = "mujoco";
const PeerSetting peer_settings[] = {
    {"480 Hz", 480, EULER, 0, 1},    {"60 Hz", 60, EULER, 0, 1},         {"240 Hz", 240, EULER, 0, 1},
    {"960 Hz", 960, EULER, 0, 1},    {"3840 Hz", 3840, EULER, 0, 1},
    {"60 Hz RK4", 60, RK4, 0, 4},    {"240 Hz RK4", 240, RK4, 0, 4},     {"960 Hz RK4", 960, RK4, 0, 4},
    {"3840 Hz RK4", 3840, RK4, 0, 4},
    {"240 Hz stiff", 240, STIFF, 0, 1}, {"960 Hz stiff", 960, STIFF, 0, 1}, {"3840 Hz stiff", 3840, STIFF, 0, 1},
    {0}
};

static struct {
    mjModel  *model;
    mjData   *data;
    PeerScene scene;
    int       id[PEER_BODIES];           /* MuJoCo's body */
    double    v[PEER_BODIES][3], spin[PEER_BODIES][3];
} mj;

typedef struct {
    char   text[16384];
    size_t used;
} Xml;

__attribute__((format(printf, 2, 3))) static void put(Xml *xml, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    int n = vsnprintf(xml->text + xml->used, sizeof xml->text - xml->used, format, list);
    va_end(list);
    if (n > 0 && xml->used + (size_t)n < sizeof xml->text)
        xml->used += (size_t)n;
}

static void put_geom(Xml *xml, const PeerBody *b)
{
    const double *s = b->size;
    if (b->kind == PEER_GROUND)
        put(xml, "<geom type='plane' size='50 50 1'/>");
    else if (b->kind == PEER_SPHERE)
        put(xml, "<geom type='sphere' size='%.17g' mass='%.17g'/>", s[0], b->mass);
    else if (b->kind == PEER_BOX)
        put(xml, "<geom type='box' size='%.17g %.17g %.17g' mass='%.17g'/>", s[0], s[1], s[2], b->mover ? 1e9 : b->mass);
    else
        put(xml, "<geom type='box' size='%.17g %.17g %.17g' mass='%.17g'/>", s[0], s[0], s[1], b->mover ? 1e9 : b->mass);
}

/* A body with the bodies hinged to it inside: places are relative to the parent, whose axes are the world's at the start. */
static void put_body(Xml *xml, int i, const double parent[3])
{
    const PeerBody *b = &mj.scene.body[i];
    put(xml, "<body name='b%d' pos='%.17g %.17g %.17g' quat='%.17g %.17g %.17g %.17g'>", i, b->at[0] - parent[0], b->at[1] - parent[1],
        b->at[2] - parent[2], b->turn[0], b->turn[1], b->turn[2], b->turn[3]);
    int hinged = 0;
    for (int k = 0; k < mj.scene.hinges; k++) {
        const PeerHinge *h = &mj.scene.hinge[k];
        if (h->to != i)
            continue;
        hinged = 1;
        put(xml, "<joint type='hinge' pos='%.17g %.17g %.17g' axis='%.17g %.17g %.17g'/>", h->at[0] - b->at[0], h->at[1] - b->at[1],
            h->at[2] - b->at[2], h->axis[0], h->axis[1], h->axis[2]);
    }
    if (b->mover)
        put(xml, "<joint type='%s' axis='%s'/>", b->kind == PEER_DISC ? "hinge" : "slide", b->kind == PEER_DISC ? "0 0 1" : "1 0 0");
    else if (!hinged)
        put(xml, "<freejoint/>");
    put_geom(xml, b);
    for (int k = 0; k < mj.scene.hinges; k++)
        if (mj.scene.hinge[k].from == i)
            put_body(xml, mj.scene.hinge[k].to, b->at);
    put(xml, "</body>");
}

/* Stiffness and damping of a contact that lasts eight steps and returns the fraction e of the speed. */
static void put_contact(Xml *xml, const PeerScene *scene, const PeerSetting *setting)
{
    double h = 1.0 / setting->rate, e = scene->restitution;
    put(xml, "<default><geom friction='%.17g 0 0' condim='%d'", scene->friction, scene->friction > 0 ? 3 : 1);
    if (e > 0) {
        double pi = acos(-1), ratio = -log(e) / sqrt(pi * pi + log(e) * log(e)), omega = pi / (8 * h);
        put(xml, " solref='%.17g %.17g' solimp='0.9999 0.9999 0.001'", -omega * omega, -2 * ratio * omega);
    } else if (setting->variant == STIFF) {
        put(xml, " solref='%.17g 1' solimp='0.99 0.9999 0.0001'", 2 * h);
    }
    put(xml, "/></default>");
}

/* MuJoCo would write a log file into the current folder; its warnings are counted in its data anyway. */
static void hear_warning(const char *text)
{
    (void)text;
}

int peer_open(const PeerScene *scene, const PeerSetting *setting)
{
    Xml *xml = calloc(1, sizeof *xml);
    double origin[3] = {0};
    if (!xml)
        return 0;
    memset(&mj, 0, sizeof mj);
    mju_user_warning = hear_warning;
    mj.scene = *scene;
    put(xml, "<mujoco><compiler angle='radian'/><option timestep='%.17g' gravity='%.17g %.17g %.17g' integrator='%s' cone='%s'/>",
        1.0 / setting->rate, scene->gravity[0], scene->gravity[1], scene->gravity[2], setting->variant == RK4 ? "RK4" : "Euler",
        setting->variant == STIFF ? "elliptic" : "pyramidal");
    put_contact(xml, scene, setting);
    put(xml, "<worldbody>");
    for (int i = 0; i < scene->bodies; i++) {
        int inside = 0;
        for (int k = 0; k < scene->hinges; k++)
            inside = inside || (scene->hinge[k].to == i && scene->hinge[k].from >= 0);
        if (scene->body[i].kind == PEER_GROUND)
            put_geom(xml, &scene->body[i]);
        else if (!inside)
            put_body(xml, i, origin);
    }
    put(xml, "</worldbody></mujoco>");

    mjVFS *files = calloc(1, sizeof *files);
    char why[500] = "";
    if (files) {
        mj_defaultVFS(files);
        mj_makeEmptyFileVFS(files, "scene.xml", (int)xml->used);
        memcpy(files->filedata[0], xml->text, xml->used);
        mj.model = mj_loadXML("scene.xml", files, why, sizeof why);
        mj_deleteVFS(files);
    }
    free(files);
    free(xml);
    mj.data = mj.model ? mj_makeData(mj.model) : 0;
    if (!mj.data) {
        fprintf(stderr, "mujoco: %s: %s\n", scene->id, why);
        exit(1);
    }
    for (int i = 0; i < scene->bodies; i++) {
        char name[16];
        snprintf(name, sizeof name, "b%d", i);
        mj.id[i] = mj_name2id(mj.model, mjOBJ_BODY, name);
        const PeerBody *b = &scene->body[i];
        if (mj.id[i] < 0 || mj.model->jnt_type[mj.model->body_jntadr[mj.id[i]]] != mjJNT_FREE)
            continue;
        double inverse[4] = {b->turn[0], -b->turn[1], -b->turn[2], -b->turn[3]};
        double *speed = mj.data->qvel + mj.model->jnt_dofadr[mj.model->body_jntadr[mj.id[i]]];
        memcpy(speed, b->v, sizeof b->v);
        mju_rotVecQuat(speed + 3, b->spin, inverse);      /* MuJoCo has it in body axes */
    }
    mj_forward(mj.model, mj.data);
    return 1;
}

void peer_move(int body, const double v[3], const double spin[3])
{
    memcpy(mj.v[body], v, sizeof mj.v[body]);
    memcpy(mj.spin[body], spin, sizeof mj.spin[body]);
}

static void set_movers(void)
{
    for (int i = 0; i < mj.scene.bodies; i++)
        if (mj.scene.body[i].mover)
            mj.data->qvel[mj.model->jnt_dofadr[mj.model->body_jntadr[mj.id[i]]]] =
                mj.scene.body[i].kind == PEER_DISC ? mj.spin[i][2] : mj.v[i][0];
}

void peer_advance(int steps)
{
    for (int k = 0; k < steps; k++) {
        set_movers();
        mj_step(mj.model, mj.data);
    }
}

void peer_state(int body, PeerState *state)
{
    memset(state, 0, sizeof *state);
    int id = mj.id[body];
    if (id < 0)
        return;
    mj_kinematics(mj.model, mj.data);                     /* mj_step leaves places of the step before */
    mj_comPos(mj.model, mj.data);
    mj_comVel(mj.model, mj.data);
    double six[6];
    mj_objectVelocity(mj.model, mj.data, mjOBJ_BODY, id, six, 0);
    memcpy(state->at, mj.data->xipos + 3 * id, sizeof state->at);
    memcpy(state->turn, mj.data->xquat + 4 * id, sizeof state->turn);
    memcpy(state->spin, six, sizeof state->spin);
    memcpy(state->v, six + 3, sizeof state->v);
    if (peer_failures() > 0)          /* MuJoCo starts anew when its state is lost: what follows is not this motion */
        state->at[0] = NAN;
}

long peer_failures(void)
{
    long n = 0;
    for (int w = mjWARN_BADQPOS; w <= mjWARN_BADQACC; w++)
        n += mj.data->warning[w].number;
    return n;
}

void peer_close(void)
{
    mj_deleteData(mj.data);
    mj_deleteModel(mj.model);
}
