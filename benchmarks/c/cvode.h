/* The peer CVODE (SUNDIALS: backward differentiation, orders 1 to 5) with a sparse analytic Jacobian and KLU.
 *
 * Included by a problem file after real.h, DIM, GAPS, rates and gaps (see located.h); the file then defines
 *     nonzeros(p)                               entries of the Jacobian
 *     jacobian(p, side, t, y, start, row, value)  its columns, compressed, rows in order, with the whole diagonal
 *         (SUNDIALS 6 adds a missing diagonal in a time that grows with the square of the dimension)
 * The sides of the gaps follow from the state at every call, so the corners fall where they fall, as in any use of
 * CVODE without root functions. */
#ifndef CVODE_H
#define CVODE_H

#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <stdlib.h>
#include <sunlinsol/sunlinsol_klu.h>
#include <sunmatrix/sunmatrix_sparse.h>

static long nonzeros(const problem *p);
static void jacobian(const problem *p, const double *side, double t, const double *y, sunindextype *start,
                     sunindextype *row, double *value);

typedef struct task {
    const problem *p;
    double *side; /* GAPS, and as many gap coordinates behind */
} task;

static const double *sides(const task *k, const double *y) {
    const int n = GAPS(k->p);
    double *const s = k->side + n;
    gaps(k->p, y, s);
    for (int i = 0; i < n; i++)
        k->side[i] = (s[i] > k->p->half_gap) - (s[i] < -k->p->half_gap);
    return k->side;
}

static int call_rates(realtype t, N_Vector y, N_Vector dy, void *user) {
    const task *const k = user;
    const double *const x = N_VGetArrayPointer(y);
    rates(k->p, sides(k, x), t, x, N_VGetArrayPointer(dy));
    return 0;
}

static int call_jacobian(realtype t, N_Vector y, N_Vector dy, SUNMatrix J, void *user, N_Vector a, N_Vector b,
                         N_Vector c) {
    const task *const k = user;
    const double *const x = N_VGetArrayPointer(y);
    (void)dy, (void)a, (void)b, (void)c;
    jacobian(k->p, sides(k, x), t, x, SUNSparseMatrix_IndexPointers(J), SUNSparseMatrix_IndexValues(J),
             SUNSparseMatrix_Data(J));
    return 0;
}

static int through_samples(void *cvode, N_Vector y, int n, int n_out, const double *t_out, double *out) {
    for (int s = 0; s < n_out; s++) {
        realtype t;
        if (CVode(cvode, t_out[s], y, &t, CV_NORMAL) < 0)
            return 2;
        for (int i = 0; i < n; i++)
            out[(size_t)s * (size_t)n + (size_t)i] = N_VGetArrayPointer(y)[i];
    }
    return 0;
}

/* From start at time 0 through the samples; tolerances rtol and rtol scale[i]. count: steps, failed steps, calls of
 * rates, Jacobians. Returns 0, 1 (setting up failed) or 2 (CVODE gave up). */
static int by_cvode(const problem *p, const double *start, const double *scale, double rtol, int n_out,
                    const double *t_out, double *out, long *count) {
    SUNContext context;
    const int n = DIM(p);
    if (SUNContext_Create(NULL, &context) != 0)
        return 1;
    task k = {.p = p, .side = calloc(2 * (size_t)GAPS(p) + 1, sizeof(double))};
    N_Vector y = N_VNew_Serial(n, context), weight = N_VNew_Serial(n, context);
    SUNMatrix J = SUNSparseMatrix(n, n, nonzeros(p), CSC_MAT, context);
    void *cvode = CVodeCreate(CV_BDF, context);
    int failed = !k.side || !y || !weight || !J || !cvode;
    SUNLinearSolver klu = failed ? NULL : SUNLinSol_KLU(y, J, context);
    if (klu != NULL) {
        for (int i = 0; i < n; i++) {
            N_VGetArrayPointer(y)[i] = start[i];
            N_VGetArrayPointer(weight)[i] = rtol * scale[i];
        }
        failed |= CVodeInit(cvode, call_rates, 0.0, y) | CVodeSVtolerances(cvode, rtol, weight);
        failed |= CVodeSetUserData(cvode, &k) | CVodeSetMaxNumSteps(cvode, 100000000);
        failed |= CVodeSetLinearSolver(cvode, klu, J) | CVodeSetJacFn(cvode, call_jacobian);
        if (!failed)
            failed = through_samples(cvode, y, n, n_out, t_out, out);
        CVodeGetNumSteps(cvode, &count[0]);
        CVodeGetNumErrTestFails(cvode, &count[1]);
        CVodeGetNumRhsEvals(cvode, &count[2]);
        CVodeGetNumJacEvals(cvode, &count[3]);
        SUNLinSolFree(klu);
    }
    SUNMatDestroy(J);
    N_VDestroy(y);
    N_VDestroy(weight);
    CVodeFree(&cvode);
    free(k.side);
    SUNContext_Free(&context);
    return klu == NULL ? 1 : failed == 2 ? 2 : failed != 0;
}
#endif
