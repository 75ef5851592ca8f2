// The table that a benchmark prints, and the file that it writes for other programs.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace cwm::benchmarks {

// One figure, beside a baseline's figure of the same run if there is one.
struct Figure {
  std::string key;
  double value = 0;
  std::string unit;
  std::string baseline = {};                  // empty: none
  std::optional<double> baseline_value = {};  // in the same unit
  std::optional<double> ratio = {};           // baseline_value / value for times, as `how` says
  std::string how;                            // what was measured, precise enough to repeat it
};

// A figure that is only a ratio, for a key that names one: its value is the ratio of `times`, whose
// own values go into the text.
Figure AsRatio(Figure times);

class Report {
 public:
  void Add(Figure figure);
  // Adds a line of details that is not a figure.
  void Detail(const std::string& text);
  // Prints the text and fails the whole run: a figure that could not be measured must not look like
  // a good one.
  void Fail(const std::string& text);
  bool failed() const { return failed_; }
  // Adds lines too many to print; they are written as a file of that name beside the figures.
  void Attach(const std::string& name, std::vector<std::string> lines);
  void Print() const;
  // Writes the figures of this run as a JSON array, replacing an existing file, and the attached
  // lines into the same folder.
  void WriteJson(const std::string& path) const;

 private:
  std::vector<Figure> figures_;
  std::vector<std::pair<std::string, std::vector<std::string>>> attached_;
  bool failed_ = false;
};

double Median(std::vector<double> values);
// The p-th quantile, 0 <= p <= 1, nearest rank.
double Quantile(std::vector<double> values, double p);

}  // namespace cwm::benchmarks
