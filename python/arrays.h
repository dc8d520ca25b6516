// Eigen's vectors as rows of NumPy's arrays, and back.
#pragma once

#include <pybind11/numpy.h>

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace orient::python {

using Array = pybind11::array_t<double, pybind11::array::c_style | pybind11::array::forcecast>;

constexpr double kAbsent = std::numeric_limits<double>::quiet_NaN();

inline double OrNan(const std::optional<double>& value) { return value.value_or(kAbsent); }

// (n, Size); rows that are absent are NaN.
template <int Size>
Array Rows(const std::vector<std::optional<Eigen::Matrix<double, Size, 1>>>& rows) {
  Array array({static_cast<pybind11::ssize_t>(rows.size()), pybind11::ssize_t{Size}});
  auto cell = array.mutable_unchecked<2>();
  for (std::size_t row = 0; row < rows.size(); ++row)
    for (int i = 0; i < Size; ++i)
      cell(static_cast<pybind11::ssize_t>(row), i) = rows[row] ? (*rows[row])[i] : kAbsent;
  return array;
}

template <typename Matrix>
Array FromMatrix(const Matrix& matrix) {
  Array array({static_cast<pybind11::ssize_t>(matrix.rows()),
               static_cast<pybind11::ssize_t>(matrix.cols())});
  auto cell = array.mutable_unchecked<2>();
  for (Eigen::Index row = 0; row < matrix.rows(); ++row)
    for (Eigen::Index col = 0; col < matrix.cols(); ++col) cell(row, col) = matrix(row, col);
  return array;
}

template <typename Vector>
Array FromVector(const Vector& vector) {
  Array array(static_cast<pybind11::ssize_t>(vector.size()));
  auto cell = array.mutable_unchecked<1>();
  for (Eigen::Index i = 0; i < vector.size(); ++i) cell(i) = vector[i];
  return array;
}

// An array, or what makes one (lists). Throws TypeError naming `what`, without its contents.
inline Array Numbers(const pybind11::object& given, const std::string& what) {
  Array array = Array::ensure(given);
  if (!array) throw pybind11::type_error(what + " must be an array of numbers");
  return array;
}

// The rows of (n, Size), or of (Size), one row. Throws ValueError naming `what` for other shapes.
template <int Size>
std::vector<Eigen::Matrix<double, Size, 1>> ToRows(const pybind11::object& given,
                                                   const std::string& what) {
  const Array array = Numbers(given, what);
  const bool one = array.ndim() == 1;
  if ((!one && array.ndim() != 2) || array.shape(array.ndim() - 1) != Size)
    throw pybind11::value_error(what + " must have the shape (n, " + std::to_string(Size) + ")");
  const pybind11::ssize_t count = one ? 1 : array.shape(0);
  std::vector<Eigen::Matrix<double, Size, 1>> rows(static_cast<std::size_t>(count));
  const double* value = array.data();
  for (auto& row : rows)
    for (int i = 0; i < Size; ++i) row[i] = *value++;
  return rows;
}

}  // namespace orient::python
