/* Runs `reflect` on cases from stdin, one line of decimal numbers each, and prints its outputs.
 *
 *     tapline vectors header reflect --language c > reflect.h
 *     cc -I dpi/include -I . dpi/examples/reflect.c -L target/debug -ltapline_dpi -o reflect
 */
#include <inttypes.h>
#include <stdio.h>

#include "reflect.h"
#include "tapline.h"

int main(void) {
    tapline_bench *bench = tapline_open("reflect", NULL, 0, 32);
    if (bench == NULL) {
        fprintf(stderr, "%s\n", tapline_error());
        return 2;
    }
    enum {
        INPUTS = sizeof(tapline_reflect_in) / sizeof(int64_t),
        OUTPUTS = sizeof(tapline_reflect_out) / sizeof(int64_t)
    };
    if (tapline_inputs(bench) != INPUTS || tapline_outputs(bench) != OUTPUTS) {
        fprintf(stderr, "the header belongs to another unit\n");
        return 2;
    }
    tapline_reflect_in in;
    tapline_reflect_out out;
    for (;;) {
        int64_t *number = (int64_t *)&in;
        for (int k = 0; k < INPUTS; k++) {
            if (scanf("%" SCNd64, &number[k]) != 1) {
                tapline_close(bench);
                return 0;
            }
        }
        if (tapline_run(bench, (const int64_t *)&in, (int64_t *)&out) != 0) {
            fprintf(stderr, "%s\n", tapline_error());
            return 2;
        }
        for (int k = 0; k < OUTPUTS; k++) {
            printf("%" PRId64 "%c", ((const int64_t *)&out)[k], k + 1 < OUTPUTS ? ' ' : '\n');
        }
    }
}
