#pragma once

#include <Eigen/Core>

#include "collision/geometry/pose.h"

// Decompositions of small symmetric matrices. They are compiled once here, because each of Eigen's
// costs the compiler several seconds in every source that uses it.
namespace cwm::perception {

// The eigenvalues in ascending order, and their unit eigenvectors as columns.
template <int kSize>
struct SymmetricEigen {
  Eigen::Vector<double, kSize> values;
  Eigen::Matrix<double, kSize, kSize> vectors;
};
SymmetricEigen<2> EigenOfSymmetric(const Eigen::Matrix2d& matrix);
SymmetricEigen<3> EigenOfSymmetric(const Matrix3& matrix);

// The solution x of A x = b for a symmetric positive semidefinite A, by LDL^T with pivots. Defined
// for 3 to 6 rows. For a singular A it may be any solution, or not finite.
template <int kSize>
Eigen::Vector<double, kSize> SolveSymmetric(const Eigen::Matrix<double, kSize, kSize>& a,
                                            const Eigen::Matrix<double, kSize, 1>& b);
Eigen::VectorXd SolveSymmetric(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

// The least pivot of LDL^T: above zero if A is positive definite. Defined for 3 to 6 rows.
template <int kSize>
double MinPivot(const Eigen::Matrix<double, kSize, kSize>& a);

// The rotation or reflection that is nearest to `columns` (least squares, by singular values).
Matrix3 NearestOrthogonal(const Matrix3& columns);

}  // namespace cwm::perception
