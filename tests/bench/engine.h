/* tests/bench/engine.h - what a driver answers, so that run.c can time any engine on any scene.
 */
#ifndef DIGBOX_BENCH_ENGINE_H
#define DIGBOX_BENCH_ENGINE_H

#include <stdio.h>
#include "scene.h"

#ifdef __cplusplus
extern "C" {
#endif

extern const char *const bench_engine;

bool bench_open(const BenchScene *scene, int threads);          /* false when the engine cannot: the reason is on stderr */
void bench_step(void);                                          /* 1/60 s; the only call that is timed */
void bench_sample(void);                                        /* after each step that counts, not timed */
void bench_pose(int body, BenchPose *pose);
int  bench_awake(void);                                         /* moving bodies awake */
void bench_kick(int body, const double v[3]);
void bench_report(FILE *out);                                   /* more fields of the row: `, name = value` */

#ifdef __cplusplus
}
#endif
#endif
