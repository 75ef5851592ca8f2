#include "clients/cli/world_contacts.h"

#include <ostream>

#include "absl/strings/str_cat.h"
#include "clients/cli/enum_names.h"
#include "clients/cli/quantity.h"
#include "clients/cli/table.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

std::string MemberText(const std::string& name, bool has_link, const std::string& link) {
  return has_link ? absl::StrCat(name, ":", link) : name;
}

void PrintContacts(const pb::GetWorldContactsResponse& response, TableStyle style,
                   std::ostream& out) {
  std::vector<TableRow> lines;
  for (const pb::WorldContactRow& row : response.rows()) {
    const std::string trust = ShortName(row.trust());
    lines.push_back(
        {{MemberText(row.object_a(), row.has_link_a(), row.link_a()), absl::StrCat(row.part_a()),
          MemberText(row.object_b(), row.has_link_b(), row.link_b()), absl::StrCat(row.part_b()),
          FormatFixed(1000 * row.distance_m(), 3), FormatVector(row.point_a()),
          FormatVector(row.point_b()), FormatVector(row.normal()),
          row.bound_m() > 0 ? absl::StrCat(trust, " to ", FormatLength(row.bound_m())) : trust}});
  }
  if (!lines.empty()) {
    PrintTable({{"A"},
                {"PART", Align::kRight},
                {"B"},
                {"PART", Align::kRight},
                {"DISTANCE mm", Align::kRight},
                {"POINT ON A m"},
                {"POINT ON B m"},
                {"NORMAL"},
                {"TRUST"}},
               lines, style, out);
  }
  out << "revision " << response.revision() << ", " << response.rows_size() << " contact"
      << (response.rows_size() == 1 ? "" : "s") << (response.is_complete() ? "" : ", not all")
      << "\n";
}

}  // namespace

absl::Status PrintWorldContacts(Session& session, const QueryArguments& query) {
  const auto options = ParseQueryOptions(query);
  if (!options.ok()) return options.status();
  pb::GetWorldContactsRequest request;
  request.set_world(session.world);
  *request.mutable_options() = *options;
  const client::Connection& connection = session.connection();
  const auto answer =
      connection.Call(&pb::QueryService::Stub::GetWorldContacts, connection.queries(), request);
  if (!answer.ok()) return answer.status();
  WarnAboutUnknownNames(session, *options);
  session.PrintList(
      *answer,
      [&] {
        for (const pb::WorldContactRow& row : answer->rows()) session.PrintLine(row);
      },
      [&] { PrintContacts(*answer, session.table_style(), session.streams.out); });
  return absl::OkStatus();
}

}  // namespace cwm::cli
