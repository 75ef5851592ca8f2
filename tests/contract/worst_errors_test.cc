// Checks that the table of worst errors in collision/README.md matches the measured errors.
#include "tests/contract/worst_errors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace cwm::collision {
namespace {

constexpr int kPoses = 500;
constexpr double kPromise_m = 1e-7;  // the accuracy of kExact
// chosen: other processors round sines and roots differently, so an error of one digit may change
// by one.
constexpr double kOfListed = 2;

using Rows = std::map<std::string, std::vector<std::string>>;  // cells, by the first of the row

// The rows of all tables that have as many cells as the table of worst errors.
Rows RowsOf(const std::string& text, std::size_t cells) {
  Rows rows;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::vector<std::string> row;
    std::istringstream rest(line.empty() || line[0] != '|' ? "" : line.substr(1));
    for (std::string cell; std::getline(rest, cell, '|');) {
      const auto begin = cell.find_first_not_of(' '), end = cell.find_last_not_of(' ');
      row.push_back(begin == std::string::npos ? "" : cell.substr(begin, end - begin + 1));
    }
    if (row.size() == cells) rows[row.front()] = row;
  }
  return rows;
}

TEST(WorstErrors, AreThoseThatTheReadmeLists) {
  const std::vector<PairErrors> all = MeasureWorstErrors(kPoses);
  const std::string measured = TableOf(all);
  std::ifstream file(CWM_COLLISION_README);
  std::ostringstream readme;
  readme << file.rdbuf();
  constexpr std::size_t kCells = 7;
  const Rows listed = RowsOf(readme.str(), kCells);
  for (const auto& [pair, cells] : RowsOf(measured, kCells)) {
    ASSERT_TRUE(listed.contains(pair)) << pair << " is not in the README; the table is\n"
                                       << measured;
    for (std::size_t k = 1; k < kCells; ++k) {
      const std::string& there = listed.at(pair)[k];
      const bool result = std::isdigit(static_cast<unsigned char>(cells[k].front())) != 0;
      if (!result || there == cells[k]) {
        EXPECT_EQ(there, cells[k]) << pair << "; the table is\n" << measured;
        continue;
      }
      const double now = std::stod(cells[k]), then = std::stod(there);
      EXPECT_TRUE(now <= kOfListed * then && now >= then / (5 * kOfListed))
          << pair << ": " << cells[k] << " where " << there << " is listed; the table is\n"
          << measured;
    }
  }
}

TEST(WorstErrors, OfTheKernelsKeepTheirPromise) {
  for (const PairErrors& pair : MeasureWorstErrors(kPoses)) {
    const WorstError& exact = pair.of[static_cast<std::size_t>(Referee::kExact)];
    ASSERT_TRUE(exact.apart_m && exact.overlapping_m);
    EXPECT_LE(std::max(*exact.apart_m, *exact.overlapping_m), kPromise_m) << pair.pair;
  }
}

}  // namespace
}  // namespace cwm::collision
