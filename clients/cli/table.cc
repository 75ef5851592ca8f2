#include "clients/cli/table.h"

#include <algorithm>
#include <ostream>

namespace cwm::cli {
namespace {

constexpr char kBold[] = "\033[1m";
constexpr char kDim[] = "\033[2m";
constexpr char kPlain[] = "\033[0m";

// The width of each column; 0 if every cell is empty.
std::vector<std::size_t> Widths(const std::vector<Column>& columns,
                                const std::vector<TableRow>& rows) {
  std::vector<std::size_t> widths(columns.size(), 0);
  for (const TableRow& row : rows) {
    for (std::size_t c = 0; c < columns.size(); ++c) {
      widths[c] = std::max(widths[c], row.cells[c].size());
    }
  }
  for (std::size_t c = 0; c < columns.size(); ++c) {
    if (widths[c] > 0) widths[c] = std::max(widths[c], columns[c].title.size());
  }
  return widths;
}

std::string Line(const std::vector<Column>& columns, const std::vector<std::size_t>& widths,
                 const std::vector<std::string>& cells) {
  std::string line;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    if (widths[c] == 0) continue;
    if (!line.empty()) line += "  ";
    const std::string padding(widths[c] - cells[c].size(), ' ');
    line += columns[c].align == Align::kRight ? padding + cells[c] : cells[c] + padding;
  }
  line.erase(line.find_last_not_of(' ') + 1);
  return line;
}

}  // namespace

void PrintTable(const std::vector<Column>& columns, const std::vector<TableRow>& rows,
                TableStyle style, std::ostream& out) {
  const bool color = style == TableStyle::kColor;
  const std::vector<std::size_t> widths = Widths(columns, rows);
  std::vector<std::string> titles;
  for (const Column& column : columns) titles.push_back(column.title);
  const std::string head = Line(columns, widths, titles);
  out << (color ? kBold + head + kPlain : head) << "\n";
  for (const TableRow& row : rows) {
    out << Line(columns, widths, row.cells) << "\n";
    if (row.note.empty()) continue;
    out << (color ? kDim + ("    " + row.note) + kPlain : "    " + row.note) << "\n";
  }
}

}  // namespace cwm::cli
