#include "cwm/error.h"

#include <utility>

namespace cwm::CWM_API {
namespace {

std::string Line(const std::string& message, const ErrorInfo& info) {
  std::string line = message;
  for (const FieldViolation& field : info.fields) {
    const std::string text = field.field + ": " + field.description;
    if (message.find(text) == std::string::npos) line += "; " + text;
  }
  if (!info.reason.empty()) line += " (" + info.reason + ")";
  return line;
}

}  // namespace

Error::Error(ErrorCode code, const std::string& message, ErrorInfo info)
    : std::runtime_error(Line(message, info)),
      code_(code),
      message_(message),
      info_(std::move(info)) {}

}  // namespace cwm::CWM_API
