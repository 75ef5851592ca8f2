// State that every command uses: the process's streams, the global options, the connection.
#pragma once

#include <google/protobuf/message.h>

#include <functional>
#include <iosfwd>
#include <memory>
#include <optional>
#include <string>

#include "clients/cli/exit_code.h"
#include "clients/cli/table.h"
#include "clients/cpp/connection.h"

namespace cwm::cli {

// Data goes to `out`; errors, warnings and progress to `err`.
struct Streams {
  std::istream& in;
  std::ostream& out;
  std::ostream& err;
  bool in_is_terminal = false;
  bool out_is_terminal = false;
  bool err_is_terminal = false;
};

enum class OutputForm {
  kTable,   // for people; the default
  kJson,    // the protobuf JSON of the response, snake_case, defaults printed
  kNdjson,  // one line per element: object, row, event
};

struct Session {
  explicit Session(Streams streams_of_the_process) : streams(streams_of_the_process) {}

  Streams streams;
  std::string address;
  std::string world;
  OutputForm form = OutputForm::kTable;
  std::optional<double> deadline_s;
  bool no_color = false;
  // Set by commands whose exit code is their answer (check --exit-code).
  ExitCode verdict_code = ExitCode::kDone;

  // Opened on first use.
  const client::Connection& connection();

  bool color() const { return streams.out_is_terminal && !no_color; }
  TableStyle table_style() const { return color() ? TableStyle::kColor : TableStyle::kPlain; }

  // Prints a response in the requested form: JSON, or by calling `table`.
  void Print(const google::protobuf::Message& response, const std::function<void()>& table);
  // The same for a list: with NDJSON, `lines` prints the elements.
  void PrintList(const google::protobuf::Message& response, const std::function<void()>& lines,
                 const std::function<void()>& table);
  // Prints one line of NDJSON.
  void PrintLine(const google::protobuf::Message& element);
  void Warn(const std::string& warning);

 private:
  std::unique_ptr<client::Connection> connection_;
};

}  // namespace cwm::cli
