/* tests/bench/looks.c - a scene as MuJoCo's own renderer draws it: `make bench SCENE=looks`.
 *
 *   looks FILE.png < scene       the scene as looks.lua prints it: camera, sun, and a line for each body
 *
 * It has what its documentation recommends for good pictures: 4 samples a pixel, a shadow map of 4096^2, a sky, haze, a floor with a
 * texture and reflections, a headlight that is dim beside the sun, materials with their shine. Its axes are z up.
 */
#define _POSIX_C_SOURCE 200809L

#include <GL/osmesa.h>
#include <math.h>
#include <mujoco/mujoco.h>
#include <png.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { WIDTH = 1280, HEIGHT = 720, ROOM = 1 << 20, FRAMES = 20 };

typedef struct Text { char *data; size_t used; } Text;

__attribute__((format(printf, 2, 3))) static void put(Text *t, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    int n = vsnprintf(t->data + t->used, ROOM - t->used, format, list);
    va_end(list);
    t->used += n > 0 && t->used + (size_t)n < ROOM ? (size_t)n : 0;
}

static void stop(const char *why)
{
    fprintf(stderr, "looks: %s\n", why);
    exit(1);
}

/* ---- the scene, y up, as MuJoCo's text, z up: (x, y, z) -> (x, -z, y) ---- */

static void put_camera(Text *t, const double at[3], const double target[3], double fov)
{
    double f[3] = {target[0] - at[0], target[1] - at[1], target[2] - at[2]};
    double x[3] = {-f[2], 0, f[0]}, y[3], n;                            /* right = forward x up */
    n = sqrt(x[0] * x[0] + x[2] * x[2]);
    for (int i = 0; i < 3; i++)
        x[i] /= n;
    y[0] = x[1] * f[2] - x[2] * f[1];
    y[1] = x[2] * f[0] - x[0] * f[2];
    y[2] = x[0] * f[1] - x[1] * f[0];
    put(t, "<camera name='eye' pos='%g %g %g' xyaxes='%g %g %g %g %g %g' fovy='%g'/>\n", at[0], -at[2], at[1], x[0], -x[2], x[1], y[0], -y[2],
        y[1], fov);
}

static void put_body(Text *t, const char *kind, const double v[14])
{
    const double h = sqrt(0.5), *q = v + 6;      /* a quarter turn about x before the body's */
    double w[4] = {h * (q[0] - q[1]), h * (q[1] + q[0]), h * (q[2] - q[3]), h * (q[3] + q[2])};
    put(t, "<body pos='%g %g %g' quat='%g %g %g %g'><geom type='%s' size='%g %g %g' rgba='%g %g %g 1' material='m%d'%s/></body>\n", v[3], -v[5],
        v[4], w[0], w[1], w[2], w[3], kind, v[0], v[1], v[2], v[10], v[11], v[12], (int)lround(10 * v[13]),
        strcmp(kind, "capsule") == 0 || strcmp(kind, "cylinder") == 0 ? " zaxis='0 1 0'" : "");
}

static void put_head(Text *t)
{
    put(t, "<mujoco><visual><quality shadowsize='4096' offsamples='4' numslices='48' numstacks='32'/>"
           "<global offwidth='%d' offheight='%d'/><map znear='0.01' zfar='50' haze='0.3' fogstart='10' fogend='40'/>"
           "<headlight ambient='0.35 0.35 0.35' diffuse='0.25 0.25 0.25' specular='0 0 0'/><rgba haze='0.75 0.79 0.84 1'/></visual>"
           "<asset><texture type='skybox' builtin='gradient' rgb1='0.75 0.79 0.84' rgb2='0.45 0.58 0.72' width='512' height='512'/>"
           "<texture name='tiles' type='2d' builtin='checker' rgb1='0.72 0.71 0.69' rgb2='0.66 0.65 0.63' mark='edge' markrgb='0.5 0.5 0.48' "
           "width='512' height='512'/><material name='floor' texture='tiles' texrepeat='1 1' texuniform='true' reflectance='0.1'/>\n", WIDTH,
        HEIGHT);
    for (int i = 0; i <= 10; i++)
        put(t, "<material name='m%d' specular='%g' shininess='%g'/>\n", i, 0.1 * i, 0.1 * i);
    put(t, "</asset><worldbody><geom type='plane' size='0 0 0.1' material='floor'/>\n");
}

static mjModel *read_scene(FILE *in)
{
    char kind[32], why[1000] = "";
    double v[14];
    Text t = {calloc(1, ROOM), 0};
    if (!t.data)
        stop("no memory");
    put_head(&t);
    while (fscanf(in, "%31s", kind) == 1) {
        int wanted = strcmp(kind, "camera") == 0 ? 7 : strcmp(kind, "sun") == 0 ? 3 : 14;
        for (int i = 0; i < wanted; i++)
            if (fscanf(in, "%lf", &v[i]) != 1)
                stop("the scene is no scene");
        if (wanted == 7)
            put_camera(&t, v, v + 3, v[6]);
        else if (wanted == 3)
            put(&t, "<light directional='true' castshadow='true' pos='%g %g %g' dir='%g %g %g' diffuse='0.75 0.74 0.70' specular='0.5 0.5 0.5'/>\n",
                v[0], -v[2], v[1], -v[0], v[2], -v[1]);
        else
            put_body(&t, kind, v);
    }
    put(&t, "</worldbody></mujoco>\n");
    mjVFS *files = malloc(sizeof *files);
    if (!files)
        stop("no memory");
    mj_defaultVFS(files);
    mj_makeEmptyFileVFS(files, "scene.xml", (int)t.used);
    memcpy(files->filedata[0], t.data, t.used);
    mjModel *m = mj_loadXML("scene.xml", files, why, sizeof why);
    mj_deleteVFS(files);
    free(files);
    free(t.data);
    if (!m)
        stop(why);
    return m;
}

/* ---- the picture ---- */

static void write_png(const char *path, const unsigned char *rgb)
{
    png_image image = {.version = PNG_IMAGE_VERSION, .width = WIDTH, .height = HEIGHT, .format = PNG_FORMAT_RGB};
    if (!png_image_write_to_file(&image, path, 0, rgb, -3 * WIDTH, NULL))      /* rows from below */
        stop(image.message);
}

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

int main(int argc, char **argv)
{
    static unsigned char rgb[3 * WIDTH * HEIGHT], corner[4];
    if (argc != 2)
        stop("usage: looks FILE.png < scene");
    OSMesaContext gl = OSMesaCreateContextExt(OSMESA_RGBA, 24, 8, 8, NULL);
    if (!gl || !OSMesaMakeCurrent(gl, corner, 0x1401, 1, 1))            /* GL_UNSIGNED_BYTE */
        stop("no OpenGL context");
    mjModel *m = read_scene(stdin);
    mjData *d = mj_makeData(m);
    mjvCamera eye;
    mjvOption option;
    mjvScene scene;
    mjrContext context;
    mjv_defaultCamera(&eye);
    mjv_defaultOption(&option);
    mjv_defaultScene(&scene);
    mjr_defaultContext(&context);
    mjv_makeScene(m, &scene, 2000);
    mjr_makeContext(m, &context, mjFONTSCALE_100);
    mjr_setBuffer(mjFB_OFFSCREEN, &context);
    scene.flags[mjRND_FOG] = scene.flags[mjRND_HAZE] = 1;
    eye.type = mjCAMERA_FIXED;
    eye.fixedcamid = 0;
    mj_forward(m, d);
    mjrRect all = {0, 0, WIDTH, HEIGHT};
    double begin = 0;
    for (int i = 0; i <= FRAMES; i++) {
        if (i == 1)
            begin = seconds();
        mjv_updateScene(m, d, &option, NULL, &eye, mjCAT_ALL, &scene);
        mjr_render(all, &scene, &context);
        mjr_readPixels(rgb, NULL, all, &context);
    }
    printf("  MuJoCo  %5.1f ms of processor time a picture (draw and read back)\n", 1e3 * (seconds() - begin) / FRAMES);
    write_png(argv[1], rgb);
    mjr_freeContext(&context);
    mjv_freeScene(&scene);
    mj_deleteData(d);
    mj_deleteModel(m);
    OSMesaDestroyContext(gl);
    return 0;
}
