/* Fixed steps of the classical Runge-Kutta method (Kutta 1901) for GB_LANE_POINTS points at once. Behind the text of a
 * model over lanes, which says
 *     LANE_N, LANE_TOTAL   states, length of the state vector
 *     ANGLES, LANE_N_ANGLES  angles among the quadratures
 *     LANE_PAR, LANE_TERMS length of par, time terms
 *     LANE_MODES, LANE_ROUNDS  modes; how often event functions are looked at (1: they read none)
 *     LANE_OUTPUTS, N_PICKS, lane_pick   outputs, those that are wanted
 *     rates, event_functions, lane_modes, outputs, is_read(reads_angles)
 *
 * Each stage has the modes of its own state, as in a run of the core that locates nothing; bits are those of such a
 * run. Time terms are computed for some steps ahead by the scalar code, or once for a period.
 *
 * Knows nothing of what the outputs are wanted for. */
#ifndef GB_LANE_RUN_H
#define GB_LANE_RUN_H

#include <stddef.h>
#include <string.h>

/* Vectors that are stepped side by side; steps whose time terms are computed ahead. */
enum { GB_ABREAST = 4, GB_AHEAD = GB_INSTANTS / 2 };
#define GB_LANE_SAME 1e-9 /* difference of time terms that repeat, relative to their largest value */

/* step, by point; parameters: rows of n_parameters numbers by point. period: steps after which the time terms are said
 * to repeat (0, or more than GB_LANE_LONGEST: not known): they are computed once where they do. From step `from` on:
 * largest, least, sum (the ends count half) and sum of squares of each wanted output by point, and every `stride` steps
 * (0: never) a row of samples [output][point]. memory: gb_lane_memory bytes, aligned as gb_lane. */
typedef struct gb_lane_job {
    double t_start;
    long steps, period, from, stride;
    const double *step, *parameters;
    double *largest, *least, *sum, *square, *samples, *last;
    void *memory;
} gb_lane_job;

typedef struct gb_lane_work {
    gb_lane par[GB_LANE_VECTORS][LANE_PAR + 1], mode[GB_LANE_VECTORS][LANE_MODES + 1], y[GB_LANE_VECTORS][LANE_TOTAL],
        step[GB_LANE_VECTORS];
    gb_lane largest[N_PICKS + 1][GB_LANE_VECTORS], least[N_PICKS + 1][GB_LANE_VECTORS],
        sum[N_PICKS + 1][GB_LANE_VECTORS], square[N_PICKS + 1][GB_LANE_VECTORS];
    double row[GB_LANE_POINTS][LANE_PAR + 1], t[GB_INSTANTS], u[LANE_INPUTS + 1][GB_INSTANTS],
        block[(LANE_TERMS + 1) * GB_INSTANTS];
    gb_lane terms[]; /* [term][instant][vector]; instants lie half a step apart */
} gb_lane_work;

GB_API size_t gb_lane_memory(void);
GB_API int gb_lane_points(void);
GB_API void gb_lanes_run(const gb_model *model, const double *inputs, const gb_lane_job *job);

int gb_lane_points(void) {
    return GB_LANE_POINTS;
}

size_t gb_lane_memory(void) {
    return sizeof(gb_lane_work) + (size_t)LANE_TERMS * GB_LANES * sizeof(gb_lane);
}

/* Instant i of the steps from `first` on: the end of every second half is that of the step. */
static double gb_lane_instant(const gb_lane_job *job, int point, long first, long i) {
    const double step = job->step[point], from = job->t_start + (double)(first + i / 2) * step;
    const double end = job->t_start + (double)(first + i / 2 + 1) * step;
    return i % 2 == 0 ? from : from + 0.5 * (end - from);
}

/* Time terms of a point at the instants work->t. */
static void gb_lane_block(const gb_model *model, gb_lane_work *work, int point) {
    model->time_terms(work->row[point], NULL, (int)GB_INSTANTS, work->t, &work->u[0][0], work->block);
    if (model->output_time_terms) {
        model->output_time_terms(work->row[point], NULL, (int)GB_INSTANTS, work->t, &work->u[0][0], work->block);
    }
}

/* Time terms at `count` instants of the steps from `first` on. */
static void gb_lane_terms(const gb_model *model, const gb_lane_job *job, gb_lane_work *work, long first, long count) {
    for (int point = 0; point < GB_LANE_POINTS; point++) {
        for (long i = 0; i < count; i += GB_INSTANTS) {
            const long here = count - i < GB_INSTANTS ? count - i : GB_INSTANTS;
            for (long l = 0; l < GB_INSTANTS; l++) {
                work->t[l] = gb_lane_instant(job, point, first, i + (l < here ? l : here - 1));
            }
            gb_lane_block(model, work, point);
            for (long l = 0; l < here; l++) {
                gb_lane *to = work->terms + (size_t)(i + l) * GB_LANE_VECTORS + point / GB_LANE_WIDTH;
                for (int j = 0; j < LANE_TERMS; j++) {
                    to[(size_t)j * GB_LANES][point % GB_LANE_WIDTH] = work->block[j * GB_INSTANTS + l];
                }
            }
        }
    }
}

/* Whether the time terms in the table of one period are the same some periods later, at instants spread over it. */
static int gb_lane_repeats(const gb_model *model, const gb_lane_job *job, gb_lane_work *work) {
    static const long later[] = {1, 7, 96};
    for (int point = 0; point < GB_LANE_POINTS; point++) {
        for (int period = 0; period < 3; period++) {
            long at[GB_INSTANTS];
            for (int l = 0; l < GB_INSTANTS; l++) {
                at[l] = 2 * job->period * l / GB_INSTANTS;
                work->t[l] = gb_lane_instant(job, point, later[period] * job->period, at[l]);
            }
            gb_lane_block(model, work, point);
            for (int j = 0; j < LANE_TERMS; j++) {
                double size = 0.0, change = 0.0;
                for (int l = 0; l < GB_INSTANTS; l++) {
                    const gb_lane *first = work->terms + (size_t)at[l] * GB_LANE_VECTORS + (size_t)j * GB_LANES;
                    const double before = first[point / GB_LANE_WIDTH][point % GB_LANE_WIDTH];
                    const double off = work->block[j * GB_INSTANTS + l] - before;
                    size = before * before > size ? before * before : size;
                    change = off * off > change ? off * off : change;
                }
                if (!(change <= GB_LANE_SAME * GB_LANE_SAME * size)) {
                    return 0;
                }
            }
        }
    }
    return 1;
}

/* Parameters, start states and steps of all points. */
static void gb_lane_start(const gb_model *model, const gb_lane_job *job, const double *inputs, gb_lane_work *work) {
    memset(work, 0, sizeof *work);
    for (int i = 0; i < LANE_INPUTS; i++) {
        for (int l = 0; l < GB_INSTANTS; l++) {
            work->u[i][l] = inputs[i];
        }
    }
    for (int point = 0; point < GB_LANE_POINTS; point++) {
        const int v = point / GB_LANE_WIDTH, l = point % GB_LANE_WIDTH;
        double *row = work->row[point], mode[LANE_MODES + 1] = {0.0}, y[LANE_TOTAL];
        memcpy(row, job->parameters + (size_t)point * (size_t)model->n_parameters,
               sizeof(double) * (size_t)model->n_parameters);
        model->prepare(row);
        for (int i = 0; i < GB_INSTANTS; i++) {
            work->t[i] = job->t_start;
        }
        model->time_terms(row, NULL, 1, work->t, &work->u[0][0], work->block);
        model->start(row, mode, work->block, y);
        for (int j = 0; j < LANE_PAR; j++) {
            work->par[v][j][l] = row[j];
        }
        for (int j = 0; j < LANE_TOTAL; j++) {
            work->y[v][j][l] = y[j];
        }
        work->step[v][l] = job->step[point];
    }
    for (int j = 0; j < N_PICKS; j++) {
        for (int v = 0; v < GB_LANE_VECTORS; v++) {
            work->largest[j][v] = gb_all(-HUGE_VAL);
            work->least[j][v] = gb_all(HUGE_VAL);
        }
    }
}

/* Modes of a state. Event functions that read modes are looked at again until none changes, from the modes before. */
GB_LANE_INLINE void gb_lane_modes(const gb_lane *par, const gb_lane *terms, const gb_lane *y, gb_lane *before,
                                  gb_lane *mode) {
    gb_lane s[LANE_MODES + 1];
    if (LANE_ROUNDS == 1) {
        event_functions(par, mode, terms, y, s);
        lane_modes(par, s, mode);
        return;
    }
    for (int round = 0, changed = 1; round < LANE_ROUNDS && changed; round++) {
        gb_lane_bits other = {0};
        event_functions(par, before, terms, y, s);
        lane_modes(par, s, mode);
        for (int i = 0; i < LANE_MODES; i++) {
            other |= mode[i] != before[i];
            before[i] = mode[i];
        }
        changed = gb_any(other);
    }
}

/* Rates of the states, and of the angles where they are read. */
GB_LANE_INLINE void gb_lane_rates(const gb_lane *par, const gb_lane *terms, const gb_lane *y, gb_lane *before,
                                  gb_lane *dy) {
    gb_lane mode[LANE_MODES + 1];
    gb_lane_modes(par, terms, y, before, mode);
    rates(par, mode, terms, y, dy, 0);
}

/* One step of GB_ABREAST vectors from `v` on, stage by stage: what one waits for, the others hide. from: steps before.
 */
GB_LANE_INLINE void gb_lane_step(const gb_lane_job *job, gb_lane_work *work, const gb_lane *terms, int v, double from) {
    enum { A = GB_ABREAST };
    gb_lane k1[A][LANE_TOTAL], k2[A][LANE_TOTAL], k3[A][LANE_TOTAL], k4[A][LANE_TOTAL], z[A][LANE_TOTAL], h[A];
    for (int a = 0; a < A; a++) {
        const gb_lane *y = work->y[v + a], step = work->step[v + a];
        h[a] = (job->t_start + (from + 1.0) * step) - (job->t_start + from * step);
        gb_lane_rates(work->par[v + a], terms + v + a, y, work->mode[v + a], k1[a]);
        for (int i = 0; i < LANE_N; i++) {
            z[a][i] = y[i] + h[a] * 0.5 * k1[a][i];
        }
    }
    for (int a = 0; a < A; a++) {
        gb_lane_rates(work->par[v + a], terms + GB_LANE_VECTORS + v + a, z[a], work->mode[v + a], k2[a]);
        for (int i = 0; i < LANE_N; i++) {
            z[a][i] = work->y[v + a][i] + h[a] * 0.5 * k2[a][i];
        }
    }
    for (int a = 0; a < A; a++) {
        gb_lane_rates(work->par[v + a], terms + GB_LANE_VECTORS + v + a, z[a], work->mode[v + a], k3[a]);
        for (int i = 0; i < LANE_N; i++) {
            z[a][i] = work->y[v + a][i] + h[a] * k3[a][i];
        }
    }
    for (int a = 0; a < A; a++) {
        gb_lane *y = work->y[v + a];
        gb_lane_rates(work->par[v + a], terms + 2 * GB_LANE_VECTORS + v + a, z[a], work->mode[v + a], k4[a]);
        for (int state = 0; state < LANE_N + (is_read(reads_angles) ? LANE_N_ANGLES : 0); state++) {
            const int i = state < LANE_N ? state : ANGLES + state - LANE_N;
            const gb_lane sum = (1.0 / 6.0 * k1[a][i] + 1.0 / 3.0 * k2[a][i]) + 1.0 / 3.0 * k3[a][i];
            y[i] = (y[i] + h[a] * sum) + h[a] * (1.0 / 6.0) * k4[a][i];
        }
    }
}

/* The wanted outputs of a vector of points. */
GB_LANE_INLINE void gb_lane_outputs(const gb_lane *par, const gb_lane *terms, const gb_lane *y, gb_lane *before,
                                    gb_lane *wanted) {
    gb_lane mode[LANE_MODES + 1], dy[LANE_TOTAL], out[LANE_OUTPUTS];
    gb_lane_modes(par, terms, y, before, mode);
    rates(par, mode, terms, y, dy, 0);
    outputs(par, mode, terms, y, dy, out);
    for (int j = 0; j < N_PICKS; j++) {
        wanted[j] = out[lane_pick[j]];
    }
}

/* After step k: extremes, sums and samples. terms: at this instant. */
static void gb_lane_look(const gb_lane_job *job, gb_lane_work *work, const gb_lane *terms, long k) {
    const int sampled = job->samples && job->stride > 0 && (k - job->from) % job->stride == 0;
    const double weight = k == job->from || k == job->steps ? 0.5 : 1.0;
    double *row = sampled ? job->samples + (size_t)((k - job->from) / job->stride) * N_PICKS * GB_LANE_POINTS : NULL;
    for (int v = 0; v < GB_LANE_VECTORS; v++) {
        gb_lane wanted[N_PICKS + 1];
        gb_lane_outputs(work->par[v], terms + v, work->y[v], work->mode[v], wanted);
        for (int j = 0; j < N_PICKS; j++) {
            const gb_lane x = wanted[j];
            if (job->largest) {
                work->largest[j][v] = gb_select(x > work->largest[j][v], x, work->largest[j][v]);
                work->least[j][v] = gb_select(x < work->least[j][v], x, work->least[j][v]);
            }
            if (job->sum) {
                work->sum[j][v] += weight * x;
                work->square[j][v] += weight * (x * x);
            }
            if (sampled) {
                memcpy(row + (size_t)j * GB_LANE_POINTS + (size_t)v * GB_LANE_WIDTH, &x, sizeof x);
            }
        }
    }
}

static void gb_lane_leave(const gb_lane_job *job, const gb_lane_work *work) {
    const size_t size = sizeof(gb_lane) * GB_LANE_VECTORS * N_PICKS;
    if (job->largest) {
        memcpy(job->largest, work->largest, size);
        memcpy(job->least, work->least, size);
    }
    if (job->sum) {
        memcpy(job->sum, work->sum, size);
        memcpy(job->square, work->square, size);
    }
    for (int point = 0; point < GB_LANE_POINTS; point++) {
        for (int j = 0; j < LANE_N; j++) {
            job->last[(size_t)point * LANE_N + (size_t)j] = work->y[point / GB_LANE_WIDTH][j][point % GB_LANE_WIDTH];
        }
    }
}

/* inputs: their constant values. */
void gb_lanes_run(const gb_model *model, const double *inputs, const gb_lane_job *job) {
    gb_lane_work *work = job->memory;
    const long looks = job->largest || job->sum;
    gb_lane_start(model, job, inputs, work);
    long period = job->period <= GB_LANE_LONGEST ? job->period : 0;
    if (period > 0) {
        gb_lane_terms(model, job, work, 0, 2 * period + 1);
        period = gb_lane_repeats(model, job, work) ? period : 0;
    }
    const long cycle = period > 0 ? period : GB_AHEAD;
    for (long k = 0;; k++) {
        const long within = k % cycle;
        if (within == 0 && period == 0) {
            gb_lane_terms(model, job, work, k, 2 * cycle + 1);
        }
        const gb_lane *terms = work->terms + (size_t)(2 * within) * GB_LANE_VECTORS;
        if (k >= job->from && (looks || (job->stride > 0 && (k - job->from) % job->stride == 0))) {
            gb_lane_look(job, work, terms, k);
        }
        if (k == job->steps) {
            break;
        }
        for (int v = 0; v < GB_LANE_VECTORS; v += GB_ABREAST) {
            gb_lane_step(job, work, terms, v, (double)(period > 0 ? within : k));
        }
    }
    gb_lane_leave(job, work);
}

#endif
