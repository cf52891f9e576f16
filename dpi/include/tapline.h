/* Stages of the tapline texture unit, bit for bit: link with libtapline_dpi.
 *
 * A bench holds one case: numbers in and numbers out, in the order of the fields that
 * `tapline vectors header STAGE --language c` declares. Its structs consist of int64_t alone, so that a pointer to one
 * is a pointer to the numbers. A bench belongs to one thread at a time.
 */
#ifndef TAPLINE_H
#define TAPLINE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tapline_bench tapline_bench;

/* A stage, or `unit`, `unit-hit`, `unit-tex`, of a unit (a TOML file, `preset:NAME`, NULL or "" for the default one).
 * plain: 1 builds it without bump and roughness. size: texels along a face of the built-in memories, 1 to 1024.
 * NULL on failure. */
tapline_bench *tapline_open(const char *subject, const char *unit, int plain, int size);
void tapline_close(tapline_bench *bench);

int tapline_inputs(const tapline_bench *bench);
int tapline_outputs(const tapline_bench *bench);

/* One case from in to out; 0, or -1 with words in tapline_error(). */
int tapline_run(tapline_bench *bench, const int64_t *in, int64_t *out);

/* The same number by number, as DPI-C likes it. */
void tapline_set(tapline_bench *bench, int index, int64_t number);
int tapline_eval(tapline_bench *bench);
int64_t tapline_get(const tapline_bench *bench, int index);

const char *tapline_error(void);
const char *tapline_version(void);

#ifdef __cplusplus
}
#endif

#endif
