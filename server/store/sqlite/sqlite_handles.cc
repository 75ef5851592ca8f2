#include "server/store/sqlite/sqlite_handles.h"

#include <sqlite3.h>

#include <cerrno>
#include <cstring>

#include "absl/strings/str_cat.h"
#include "server/core/error.h"
#include "server/store/store_contract.h"

namespace cwm::server {
namespace {

// The errors of the system that mean no room: what was written before counts, the call does not.
bool MeansNoRoom(int error) { return error == ENOSPC || error == EDQUOT || error == EFBIG; }

// The errors of the system that mean that no file can be opened for now.
bool MeansNoFiles(int error) { return error == EMFILE || error == ENFILE || error == ENOMEM; }

// The error of the last call of the system that failed on the database or its log. SQLite often
// forgets it for the log.
int LastSystemError(sqlite3* database) {
  if (const int error = sqlite3_system_errno(database); error != 0) return error;
  sqlite3_file* log = nullptr;
  int error = 0;
  if (sqlite3_file_control(database, "main", SQLITE_FCNTL_JOURNAL_POINTER, &log) == SQLITE_OK &&
      log != nullptr && log->pMethods != nullptr) {
    log->pMethods->xFileControl(log, SQLITE_FCNTL_LAST_ERRNO, &error);
  }
  return error;
}

absl::Status ErrorOf(sqlite3* database, int code) {
  const int primary = code & 0xFF;
  const char* const path = sqlite3_db_filename(database, "main");
  std::string message = absl::StrCat(path == nullptr ? "" : path, ": ", sqlite3_errmsg(database));
  const int error =
      primary == SQLITE_IOERR || primary == SQLITE_CANTOPEN ? LastSystemError(database) : 0;
  if (error != 0) {
    absl::StrAppend(&message, " (", std::strerror(error), ")");
  }
  switch (primary) {
    case SQLITE_FULL:
      return DiskFull(message);
    case SQLITE_IOERR:
      // A write that found no room changed nothing that counts; a flush that did may have.
      if (code == SQLITE_IOERR_WRITE && MeansNoRoom(error)) return DiskFull(message);
      return StoreFailed(message);
    case SQLITE_TOOBIG:
      return MakeError(absl::StatusCode::kResourceExhausted,
                       absl::StrCat(message, ": a row must have at most ",
                                    sqlite3_limit(database, SQLITE_LIMIT_LENGTH, -1), " bytes"),
                       {.reason = "SNAPSHOT_TOO_LARGE"});
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return StoreDamaged(message);
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return MakeError(absl::StatusCode::kFailedPrecondition,
                       absl::StrCat(message, ": another program has the file open; end it first"),
                       {.reason = "STORE_LOCKED"});
    case SQLITE_CANTOPEN:
      if (MeansNoFiles(error)) return OutOfFiles(message);
      [[fallthrough]];
    case SQLITE_READONLY:
    case SQLITE_PERM:
    case SQLITE_AUTH:
      return MakeError(
          absl::StatusCode::kFailedPrecondition,
          absl::StrCat(message, ": the file and its directory must be writable for this user"),
          {.reason = "STORE_NOT_WRITABLE"});
    default:
      return StoreFailed(message);
  }
}

absl::Status StatusOfCode(sqlite3* database, int code) {
  if (code == SQLITE_OK || code == SQLITE_ROW || code == SQLITE_DONE) return absl::OkStatus();
  return ErrorOf(database, code);
}

}  // namespace

void CloseDatabase::operator()(sqlite3* database) const { sqlite3_close_v2(database); }
void FinalizeStatement::operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }

Statement& Statement::Note(int code) {
  if (bind_code_ == SQLITE_OK) bind_code_ = code;
  return *this;
}

Statement& Statement::Bind(int index, std::int64_t value) {
  return Note(sqlite3_bind_int64(statement_.get(), index, value));
}

Statement& Statement::BindText(int index, std::string_view text) {
  // A null pointer would bind NULL.
  return Note(sqlite3_bind_text64(statement_.get(), index, text.empty() ? "" : text.data(),
                                  text.size(), SQLITE_STATIC, SQLITE_UTF8));
}

Statement& Statement::BindBlob(int index, std::string_view bytes) {
  return Note(sqlite3_bind_blob64(statement_.get(), index, bytes.empty() ? "" : bytes.data(),
                                  bytes.size(), SQLITE_STATIC));
}

absl::StatusOr<bool> Statement::Step() {
  const int code = bind_code_ != SQLITE_OK ? bind_code_ : sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  return ErrorOf(sqlite3_db_handle(statement_.get()), code);
}

absl::Status Statement::Run() {
  absl::StatusOr<bool> has_row = true;
  do {
    has_row = Step();
  } while (has_row.ok() && *has_row);
  Reset();
  return has_row.status();
}

void Statement::Reset() {
  sqlite3_reset(statement_.get());
  sqlite3_clear_bindings(statement_.get());
  bind_code_ = SQLITE_OK;
}

std::int64_t Statement::Int(int column) const {
  return sqlite3_column_int64(statement_.get(), column);
}

std::string_view Statement::Bytes(int column) const {
  const void* const data = sqlite3_column_blob(statement_.get(), column);
  if (data == nullptr) return {};
  const int size = sqlite3_column_bytes(statement_.get(), column);
  return {static_cast<const char*>(data), static_cast<std::size_t>(size)};
}

absl::StatusOr<Database> Database::Open(const std::string& path, bool may_create,
                                        const std::string& vfs) {
  const int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE |
                    (may_create ? SQLITE_OPEN_CREATE : 0);
  sqlite3* raw = nullptr;
  const int code = sqlite3_open_v2(path.c_str(), &raw, flags, vfs.empty() ? nullptr : vfs.c_str());
  Database database;
  database.database_.reset(raw);
  if (raw == nullptr) return StoreFailed(absl::StrCat(path, ": no memory to open it"));
  if (absl::Status status = database.StatusOf(code); !status.ok()) return status;
  sqlite3_db_config(raw, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
  return database;
}

absl::Status Database::Execute(const std::string& sql) {
  return StatusOf(sqlite3_exec(get(), sql.c_str(), nullptr, nullptr, nullptr));
}

absl::StatusOr<Statement> Database::Prepare(const std::string& sql) {
  sqlite3_stmt* statement = nullptr;
  const int code = sqlite3_prepare_v3(get(), sql.data(), static_cast<int>(sql.size()),
                                      SQLITE_PREPARE_PERSISTENT, &statement, nullptr);
  if (absl::Status status = StatusOf(code); !status.ok()) return status;
  return Statement(statement);
}

absl::StatusOr<std::int64_t> Database::Int(const std::string& sql) {
  absl::StatusOr<Statement> statement = Prepare(sql);
  if (!statement.ok()) return statement.status();
  const absl::StatusOr<bool> has_row = statement->Step();
  if (!has_row.ok()) return has_row.status();
  if (!*has_row) return StoreDamaged(absl::StrCat("no row answers: ", sql));
  return statement->Int(0);
}

absl::StatusOr<std::string> Database::Text(const std::string& sql) {
  absl::StatusOr<Statement> statement = Prepare(sql);
  if (!statement.ok()) return statement.status();
  const absl::StatusOr<bool> has_row = statement->Step();
  if (!has_row.ok()) return has_row.status();
  if (!*has_row) return StoreDamaged(absl::StrCat("no row answers: ", sql));
  return std::string(statement->Bytes(0));
}

absl::Status Database::StatusOf(int code) const { return StatusOfCode(get(), code); }

absl::StatusOr<Transaction> Transaction::Begin(Database& database) {
  if (absl::Status status = database.Execute("BEGIN IMMEDIATE"); !status.ok()) return status;
  return Transaction(&database);
}

// Some errors have ended the transaction already; a second end is a harmless error.
Transaction::~Transaction() {
  if (database_ != nullptr) (void)database_->Execute("ROLLBACK");
}

absl::Status Transaction::Commit() {
  absl::Status status = database_->Execute("COMMIT");
  if (status.ok()) database_ = nullptr;
  return status;
}

}  // namespace cwm::server
