#include "server/wire/field_path.h"

#include <utility>

#include "server/core/error.h"

namespace cwm::server {

FieldPath FieldPath::OfRequest(std::string_view name) {
  static const FieldPath request;
  return request.Field(name);
}

std::string FieldPath::str() const {
  std::string path = parent_ != nullptr ? parent_->str() : "";
  if (name_.empty()) return path;
  if (!path.empty()) path += '.';
  path += name_;
  if (index_ == kNoIndex) return path;
  path += '[';
  path += std::to_string(index_);
  path += ']';
  return path;
}

absl::Status FieldPath::Error(std::string description) const {
  return InvalidField(str(), std::move(description));
}

}  // namespace cwm::server
