#include "perception/cloud/decompositions.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

namespace cwm::perception {
namespace {

template <int kSize>
SymmetricEigen<kSize> EigenOf(const Eigen::Matrix<double, kSize, kSize>& matrix) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, kSize, kSize>> solver(matrix);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

}  // namespace

SymmetricEigen<2> EigenOfSymmetric(const Eigen::Matrix2d& matrix) { return EigenOf<2>(matrix); }

SymmetricEigen<3> EigenOfSymmetric(const Matrix3& matrix) { return EigenOf<3>(matrix); }

template <int kSize>
Eigen::Vector<double, kSize> SolveSymmetric(const Eigen::Matrix<double, kSize, kSize>& a,
                                            const Eigen::Matrix<double, kSize, 1>& b) {
  return a.ldlt().solve(b);
}

Eigen::VectorXd SolveSymmetric(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  return a.ldlt().solve(b);
}

template <int kSize>
double MinPivot(const Eigen::Matrix<double, kSize, kSize>& a) {
  return a.ldlt().vectorD().minCoeff();
}

Matrix3 NearestOrthogonal(const Matrix3& columns) {
  const Eigen::JacobiSVD<Matrix3> svd(columns, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

template Eigen::Vector<double, 3> SolveSymmetric(const Eigen::Matrix<double, 3, 3>&,
                                                 const Eigen::Matrix<double, 3, 1>&);
template Eigen::Vector<double, 4> SolveSymmetric(const Eigen::Matrix<double, 4, 4>&,
                                                 const Eigen::Matrix<double, 4, 1>&);
template Eigen::Vector<double, 5> SolveSymmetric(const Eigen::Matrix<double, 5, 5>&,
                                                 const Eigen::Matrix<double, 5, 1>&);
template Eigen::Vector<double, 6> SolveSymmetric(const Eigen::Matrix<double, 6, 6>&,
                                                 const Eigen::Matrix<double, 6, 1>&);
template double MinPivot(const Eigen::Matrix<double, 3, 3>&);
template double MinPivot(const Eigen::Matrix<double, 4, 4>&);
template double MinPivot(const Eigen::Matrix<double, 5, 5>&);
template double MinPivot(const Eigen::Matrix<double, 6, 6>&);

}  // namespace cwm::perception
