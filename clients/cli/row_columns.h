// Converts answers received as columns to the rows that the command line prints.
#pragma once

#include "absl/status/status.h"
#include "cwm/v1/query.pb.h"

namespace cwm::cli {

// derived: the most rows that the server answers as messages
// (GetServerInfo.limits.max_rows_as_messages); longer batches are answered as columns.
inline constexpr std::size_t kMaxMessageRows = 1024;

// Fills in `rows` from the columns, which must be F64, and clears the columns. Does nothing for an
// answer that has rows already. DATA_LOSS if the columns are inconsistent.
absl::Status ExpandRows(cwm::v1::CheckCollisionsResponse& response);
absl::Status ExpandRows(cwm::v1::GetDistancesResponse& response);
absl::Status ExpandRows(cwm::v1::GetContactsResponse& response);

}  // namespace cwm::cli
