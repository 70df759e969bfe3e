// Layouts of Eigen that the interface would read as other numbers. scripts/check-c.sh compiles each LAYOUT: only 0,
// which holds what lies in memory as it is read, may compile.
#include <extricate.hpp>

#include <Eigen/Core>

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

void layouts(const extricate::Scene& scene, const extricate::Solver& solver) {
    Eigen::MatrixXd columns(3, 3);
    RowMatrix rows(3, 3);
    const Eigen::VectorXd vector(3);
#if LAYOUT == 0
    (void)extricate::query_batch(scene, rows);
    (void)solver.query(vector);
    (void)solver.query(Eigen::Vector3d());
    (void)solver.query(columns.col(0));
    (void)solver.query(rows.row(0));
    (void)solver.query(vector.head(3));
#elif LAYOUT == 1
    (void)extricate::query_batch(scene, columns);
#elif LAYOUT == 2
    (void)solver.query(columns.row(0));
#elif LAYOUT == 3
    (void)solver.query(rows.col(0));
#elif LAYOUT == 4
    (void)extricate::query_batch(scene, rows.leftCols(2));
#endif
}
