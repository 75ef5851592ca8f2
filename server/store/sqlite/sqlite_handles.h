// A database of SQLite and its statements as values. The header of SQLite is included in the
// sources of this folder alone.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

struct sqlite3;
struct sqlite3_backup;
struct sqlite3_stmt;

namespace cwm::server {

struct CloseDatabase {
  void operator()(sqlite3* database) const;
};
struct FinalizeStatement {
  void operator()(sqlite3_stmt* statement) const;
};

// A prepared statement. What is bound must live until the next Reset or Run.
class Statement {
 public:
  Statement() = default;
  explicit Statement(sqlite3_stmt* statement) : statement_(statement) {}

  Statement& Bind(int index, std::int64_t value);  // from 1
  Statement& BindText(int index, std::string_view text);
  Statement& BindBlob(int index, std::string_view bytes);
  // Goes to the next row; false after the last one. Also the error of a value that could not be
  // bound.
  absl::StatusOr<bool> Step();
  // Steps to the end, and makes the statement ready for the next use.
  absl::Status Run();
  void Reset();

  std::int64_t Int(int column) const;  // from 0
  // Text or a blob, as it is stored; valid until the next step.
  std::string_view Bytes(int column) const;

 private:
  Statement& Note(int code);

  std::unique_ptr<sqlite3_stmt, FinalizeStatement> statement_;
  int bind_code_ = 0;  // of the first value since the last reset that could not be bound
};

class Database {
 public:
  Database() = default;
  // Opens the file for reading and writing. An empty vfs is the default one. Closing the database
  // does not checkpoint its log.
  static absl::StatusOr<Database> Open(const std::string& path, bool may_create,
                                       const std::string& vfs = {});

  absl::Status Execute(const std::string& sql);
  absl::StatusOr<Statement> Prepare(const std::string& sql);
  // The first column of the only row.
  absl::StatusOr<std::int64_t> Int(const std::string& sql);
  absl::StatusOr<std::string> Text(const std::string& sql);
  // OK, or the error of a call that returned `code`, as Store lists them.
  absl::Status StatusOf(int code) const;
  sqlite3* get() const { return database_.get(); }
  explicit operator bool() const { return database_ != nullptr; }

 private:
  std::unique_ptr<sqlite3, CloseDatabase> database_;
};

// A transaction that is rolled back unless it was committed.
class Transaction {
 public:
  static absl::StatusOr<Transaction> Begin(Database& database);
  Transaction(Transaction&& other) noexcept : database_(other.database_) {
    other.database_ = nullptr;
  }
  ~Transaction();
  absl::Status Commit();

 private:
  explicit Transaction(Database* database) : database_(database) {}
  Database* database_;
};

}  // namespace cwm::server
