#include "server/store/decode_fault.h"

#include "absl/strings/str_cat.h"
#include "server/core/error.h"

namespace cwm::server {

absl::Status Broken(std::string_view field, std::string_view rule) {
  return absl::DataLossError(absl::StrCat(std::string(field), ": ", std::string(rule)));
}

absl::Status Within(std::string_view outer, const absl::Status& status) {
  absl::Status named(status.code(), absl::StrCat(std::string(outer), ".", status.message()));
  status.ForEachPayload(
      [&](absl::string_view url, const absl::Cord& payload) { named.SetPayload(url, payload); });
  return named;
}

absl::Status Damaged(std::string_view place, std::string_view what) {
  return MakeError(
      absl::StatusCode::kDataLoss,
      absl::StrCat("the store is damaged: ", std::string(place), ": ", std::string(what)),
      {.reason = "STORE_DAMAGED"});
}

absl::Status DamagedAt(std::string_view place, const absl::Status& status) {
  const bool is_broken = absl::IsDataLoss(status) && DetailsOf(status).reason.empty();
  const std::string_view message(status.message().data(), status.message().size());
  return is_broken ? Damaged(place, message) : status;
}

}  // namespace cwm::server
