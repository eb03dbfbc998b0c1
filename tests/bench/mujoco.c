/* tests/bench/mujoco.c - driver of MuJoCo (Debian's libmujoco-dev): Newton, pyramidal cone, four steps of 1/240 s, small scenes only.
 *
 * Chains are trees of ball joints, its natural form, so that they cannot come apart.
 */
#include <mujoco/mujoco.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include "engine.h"

enum { SUBSTEPS = 4, MOST_BODIES = 2200 };

const char *const bench_engine = "mujoco";

static struct {
    mjModel          *model;
    mjData           *data;
    const BenchScene *scene;
    int              *id;           /* MuJoCo's body, or 0 */
    char             *text;
    size_t            used, room;
} mj;

__attribute__((format(printf, 1, 2))) static void put(const char *format, ...)
{
    if (mj.room - mj.used < 4096) {
        mj.room = mj.room ? 2 * mj.room : 1 << 20;
        mj.text = realloc(mj.text, mj.room);
        if (!mj.text)
            abort();
    }
    va_list list;
    va_start(list, format);
    int n = vsnprintf(mj.text + mj.used, mj.room - mj.used, format, list);
    va_end(list);
    mj.used += n > 0 ? (size_t)n : 0;
}

static void put_geom(const BenchBody *b)
{
    const double *r = b->size;
    if (b->kind == BENCH_SPHERE)
        put("<geom type='sphere' size='%.17g'", r[0]);
    else if (b->kind == BENCH_BOX)
        put("<geom type='box' size='%.17g %.17g %.17g'", r[0], r[1], r[2]);
    else if (b->kind == BENCH_CAPSULE)
        put("<geom type='capsule' size='%.17g' fromto='0 %.17g 0 0 %.17g 0'", r[0], -r[1], r[1]);
    else
        put("<geom type='mesh' mesh='hull'");
    if (b->fixed)
        put(" pos='%.17g %.17g %.17g'", b->at[0], b->at[1], b->at[2]);
    put("/>\n");
}

/* The links of a chain lie inside one another: body i, and those after it up to the next fixed one. */
static int put_chain(int i)
{
    int depth = 0;
    for (; i < mj.scene->bodies && !mj.scene->body[i].fixed; i++, depth++) {
        const BenchBody *b = &mj.scene->body[i];
        double half = b->size[0] + b->size[1];
        if (depth == 0)
            put("<body name='b%d' pos='%.17g %.17g %.17g' quat='%.17g %.17g %.17g %.17g'>", i, b->at[0], b->at[1], b->at[2], b->turn[3],
                b->turn[0], b->turn[1], b->turn[2]);
        else
            put("<body name='b%d' pos='0 %.17g 0'>", i, -2 * half);
        put("<joint type='ball' pos='0 %.17g 0'/>", half);
        put_geom(b);
    }
    while (depth-- > 0)
        put("</body>");
    return i;
}

static void put_free(int i)
{
    const BenchBody *b = &mj.scene->body[i];
    put("<body name='b%d' pos='%.17g %.17g %.17g' quat='%.17g %.17g %.17g %.17g'><freejoint/>", i, b->at[0], b->at[1], b->at[2],
        b->turn[3], b->turn[0], b->turn[1], b->turn[2]);
    put_geom(b);
    put("</body>");
}

static void put_scene(const BenchScene *s)
{
    long contacts = s->linked ? 200 : 5L * s->bodies + 400, rows = s->linked ? 1000 : 4 * contacts;
    double hull = 0;
    put("<mujoco><compiler angle='radian'/><size nconmax='%ld' njmax='%ld' nstack='%ld'/>", contacts, rows, 4000L * 1048576 / 8);
    put("<option timestep='%.17g' gravity='0 -9.81 0' solver='Newton' cone='pyramidal'/>", 1.0 / 60 / SUBSTEPS);
    put("<default><geom density='1000' friction='0.5 0.005 0.0001'/></default>");
    for (int i = 0; i < s->bodies; i++)
        hull = s->body[i].kind == BENCH_HULL ? s->body[i].size[0] : hull;
    if (hull > 0) {
        Icosahedron ico;
        bench_icosahedron(&ico);
        put("<asset><mesh name='hull' vertex='");
        for (int i = 0; i < HULL_POINTS; i++)
            put("%.17g %.17g %.17g ", ico.point[i][0] * hull, ico.point[i][1] * hull, ico.point[i][2] * hull);
        put("'/></asset>");
    }
    put("<worldbody>");
    for (int i = 0; i < s->bodies; i++)
        if (s->body[i].fixed && !s->linked)
            put_geom(&s->body[i]);
        else if (!s->body[i].fixed && s->linked)
            i = put_chain(i);
        else if (!s->body[i].fixed)
            put_free(i);
    put("</worldbody></mujoco>");
}

/* MuJoCo would write a log file into the current folder. */
static void hear_warning(const char *text) { (void)text; }

static void hear_error(const char *text)
{
    fprintf(stderr, "mujoco: %s\n", text);
    exit(77);
}

static void load(void)
{
    mjVFS *files = calloc(1, sizeof *files);
    char why[500] = "";
    if (!files)
        abort();
    mj_defaultVFS(files);
    mj_makeEmptyFileVFS(files, "scene.xml", (int)mj.used);
    memcpy(files->filedata[0], mj.text, mj.used);
    mj.model = mj_loadXML("scene.xml", files, why, sizeof why);
    mj_deleteVFS(files);
    free(files);
    free(mj.text);
    mj.data = mj.model ? mj_makeData(mj.model) : NULL;
    if (!mj.data)
        fprintf(stderr, "mujoco: %s\n", why[0] ? why : "no memory for its data");
}

bool bench_open(const BenchScene *scene, int threads)
{
    if (threads > 1 || scene->sleeping || scene->bodies > MOST_BODIES) {
        fprintf(stderr, "mujoco: one thread, no sleep, at most %d bodies\n", MOST_BODIES);
        return false;
    }
    mju_user_warning = hear_warning;
    mju_user_error = hear_error;
    mj.scene = scene;
    mj.id = calloc((size_t)scene->bodies, sizeof *mj.id);
    put_scene(scene);
    load();
    if (!mj.id || !mj.data)
        return false;
    for (int i = 0; i < scene->bodies; i++) {
        char name[24];
        snprintf(name, sizeof name, "b%d", i);
        mj.id[i] = scene->body[i].fixed ? 0 : mj_name2id(mj.model, mjOBJ_BODY, name);
    }
    mj_forward(mj.model, mj.data);
    return true;
}

void bench_step(void)
{
    for (int i = 0; i < SUBSTEPS; i++)
        mj_step(mj.model, mj.data);
}

void bench_sample(void) {}

void bench_pose(int body, BenchPose *pose)
{
    const BenchBody *b = &mj.scene->body[body];
    memcpy(pose->at, b->at, sizeof pose->at);
    memcpy(pose->turn, b->turn, sizeof pose->turn);
    if (mj.id[body] <= 0)
        return;
    mj_kinematics(mj.model, mj.data);           /* mj_step leaves places of the step before */
    memcpy(pose->at, mj.data->xpos + 3 * mj.id[body], sizeof pose->at);
    for (int i = 0; i < 4; i++)
        pose->turn[i] = mj.data->xquat[4 * mj.id[body] + (i + 1) % 4];
}

int bench_awake(void) { return -1; }

void bench_kick(int body, const double v[3]) { (void)body, (void)v; }

void bench_report(FILE *out) { fprintf(out, ", points = %d", mj.data->ncon); }
