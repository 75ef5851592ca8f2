// Checks the standard deviations that a fit reports: 68 % of normally distributed errors lie within
// one of them.
#pragma once

#include <map>
#include <string>

#include "tests/benchmarks/quality/seen_shapes.h"

namespace cwm::benchmarks {

struct WithinSigma {
  int count = 0;
  int within = 0;

  double share() const { return count == 0 ? 0 : static_cast<double>(within) / count; }
};

class ParameterCalibration {
 public:
  // Adds a found shape of the true one's type. Parameters without a positive deviation (held, or
  // unknown) are not counted.
  void Add(const TrueShape& truth, const FoundShape& found);

  // By parameter: "sphere centre", "cylinder radius", "box size", ...
  const std::map<std::string, WithinSigma>& parameters() const { return parameters_; }
  WithinSigma all() const;

 private:
  void AddBox(const TrueShape& truth, const FoundShape& found);

  std::map<std::string, WithinSigma> parameters_;
};

}  // namespace cwm::benchmarks
