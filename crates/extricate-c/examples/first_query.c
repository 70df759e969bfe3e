/* The nearest free configuration of a scene that comes with the library; plain C. */
#include <stdio.h>
#include <stdlib.h>

#include <extricate.h>

static void expect(ExtricateStatus status) {
    if (status != EXTRICATE_OK) {
        fprintf(stderr, "%s\n", extricate_last_error());
        exit(1);
    }
}

int main(void) {
    ExtricateScene *scene = NULL;
    ExtricateSolver *solver = NULL;
    ExtricateAnswer *answer = NULL;
    const double q[3] = {0.4, 0.0, 0.0};

    if (extricate_abi() != EXTRICATE_ABI) return 1;
    expect(extricate_scene_builtin("planar-arm", &scene));
    expect(extricate_solver_new(scene, NULL, &solver));
    expect(extricate_query(solver, q, 3, &answer));

    const ExtricateSummary *summary = extricate_answer_summary(answer);
    const double *witness = extricate_answer_witness(answer);
    printf("%.6f away, at least %.6f: [%.6f, %.6f, %.6f]\n", summary->depth, summary->lower_bound, witness[0], witness[1],
           witness[2]);

    extricate_answer_free(answer);
    extricate_solver_free(solver);
    extricate_scene_free(scene);
    return 0;
}
