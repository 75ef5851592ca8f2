// What a benchmark prints and what it leaves behind for machines.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace cwm::benchmarks {

// One figure, beside a rival's figure of the same run where there is one.
struct Figure {
  std::string key;
  double value = 0;
  std::string unit;
  std::string rival = {};                  // empty: none
  std::optional<double> rival_value = {};  // in the same unit
  std::optional<double> ratio = {};        // rival_value / value for times, as `how` says
  std::string how;                         // what was measured, so that a stranger could repeat it
};

// The figure of a ratio alone, of a key that names one: its value is the ratio of `times`, whose own
// values go into the text.
Figure AsRatio(Figure times);

class Report {
 public:
  void Add(Figure figure);
  // A line of the table that is not a figure of its own: details beside the keys.
  void Detail(const std::string& text);
  // Prints it as well; a figure that cannot be had fails the whole run, instead of being a good one.
  void Fail(const std::string& text);
  bool failed() const { return failed_; }
  // Lines too many to print, written as a file of that name beside the figures.
  void Attach(const std::string& name, std::vector<std::string> lines);
  void Print() const;
  // Writes the figures of this run as a JSON array, in place of a file that is there already, and
  // what was attached into the same folder.
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
