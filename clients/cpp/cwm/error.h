// The exception of every call and of every argument that cannot be right.
#pragma once

#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "cwm/namespace.h"

namespace cwm::CWM_API {

// The codes of gRPC.
enum class ErrorCode {
  kCancelled = 1,
  kUnknown = 2,
  kInvalidArgument = 3,   // fields() say which and by which rule
  kDeadlineExceeded = 4,  // the timeout of the call passed
  kNotFound = 5,          // no such world, object, robot or geometry
  kAlreadyExists = 6,
  kPermissionDenied = 7,    // another user could answer in the server's place, or it refuses
  kResourceExhausted = 8,   // the server is busy or a limit was met; see retry_after_s()
  kFailedPrecondition = 9,  // such as WORLD_REPLACED, SCAN_CONTRADICTS_WORLD
  kAborted = 10,            // such as REVISION_MISMATCH: something else happened first
  kOutOfRange = 11,         // such as REVISION_COMPACTED: the revision is no longer kept
  kUnimplemented = 12,
  kInternal = 13,
  kUnavailable = 14,  // no server answers
  kDataLoss = 15,
  kUnauthenticated = 16,
};

// A field of a request, or an argument, and the rule that its value breaks.
struct FieldViolation {
  std::string field;        // "poses[3]", "options.margin_m"
  std::string description;  // the value and the rule
};

// Details of a failure from the server, besides its message.
struct ErrorInfo {
  std::string reason =
      {};  // UPPER_SNAKE, stable for programs, such as OBJECT_UNKNOWN; may be empty
  std::vector<FieldViolation> fields = {};
  std::map<std::string, std::string> metadata = {};  // names and values that belong to the reason
  std::optional<double> retry_after_s = {};          // when the server wants to be asked again
};

// what() is one line for people: the message, the fields that it does not mention, the reason.
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, const std::string& message, ErrorInfo info = {});

  ErrorCode code() const { return code_; }
  const std::string& message() const { return message_; }
  const std::string& reason() const { return info_.reason; }
  const std::vector<FieldViolation>& fields() const { return info_.fields; }
  const std::map<std::string, std::string>& metadata() const { return info_.metadata; }
  std::optional<double> retry_after_s() const { return info_.retry_after_s; }

 private:
  ErrorCode code_;
  std::string message_;
  ErrorInfo info_;
};

}  // namespace cwm::CWM_API
