// Aligned tables for people.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

namespace cwm::cli {

enum class Align { kLeft, kRight };

struct Column {
  std::string title;
  Align align = Align::kLeft;
};

struct TableRow {
  std::vector<std::string> cells;  // as many as columns
  std::string note = {};           // printed under the row, indented; empty: nothing
};

enum class TableStyle { kPlain, kColor };

// Columns that are empty in every row are left out. Titles are bold in colour.
void PrintTable(const std::vector<Column>& columns, const std::vector<TableRow>& rows,
                TableStyle style, std::ostream& out);

}  // namespace cwm::cli
