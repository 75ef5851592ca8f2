// cwm distance, cwm contacts
#include <memory>

#include "absl/strings/str_cat.h"
#include "clients/cli/commands.h"
#include "clients/cli/enum_names.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/one_of.h"
#include "clients/cli/quantity.h"
#include "clients/cli/query_arguments.h"
#include "clients/cli/table.h"
#include "clients/cli/world_contacts.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

struct PairArguments {
  BodyArguments body;
  QueryArguments query;
  pb::DistancePairs pairs = pb::DISTANCE_PAIRS_UNSPECIFIED;  // of distances
  bool gradient = false;                                     // likewise
  int max_contacts_per_pair = 0;
  bool all = false;  // of contacts: those of the whole world, without a body
};

std::string TrustText(const pb::PairRow& pair) {
  const std::string trust = ShortName(pair.trust());
  return pair.bound_m() > 0 ? absl::StrCat(trust, " to ", FormatLength(pair.bound_m())) : trust;
}

std::vector<std::string> VariablesOf(const pb::GetDistancesResponse& response) {
  return {response.variables().begin(), response.variables().end()};
}
std::vector<std::string> VariablesOf(const pb::GetContactsResponse&) { return {}; }

template <class Response>
void PrintPairs(const Response& response, Session& session) {
  const google::protobuf::RepeatedPtrField<pb::PairRows>& rows = response.rows();
  std::vector<Column> columns = {{"ROW", Align::kRight},
                                 {"OBJECT"},
                                 {"OBJECT LINK"},
                                 {"PART", Align::kRight},
                                 {"BODY LINK"},
                                 {"DISTANCE mm", Align::kRight},
                                 {"POINT ON BODY m"},
                                 {"POINT ON OBJECT m"},
                                 {"NORMAL"},
                                 {"TRUST"}};
  for (const std::string& variable : VariablesOf(response)) {  // in m/rad or m/m
    columns.push_back({absl::StrCat("d/", variable), Align::kRight});
  }
  columns.push_back({"KINK"});
  std::vector<TableRow> lines;
  for (int row = 0; row < rows.size(); ++row) {
    if (rows[row].answers().empty()) {
      lines.push_back({{absl::StrCat(row), "none"}});
      lines.back().cells.resize(columns.size());
    }
    for (const pb::PairRow& pair : rows[row].answers()) {
      lines.push_back(
          {{absl::StrCat(row), ObstacleName(pair), pair.object_link(),
            absl::StrCat(pair.object_part()), BodyName(pair),
            FormatFixed(1000 * pair.distance_m(), 3), FormatVector(pair.point_body()),
            FormatVector(pair.point_object()), FormatVector(pair.normal()), TrustText(pair)}});
      for (const double derivative : pair.joint_gradient()) {
        lines.back().cells.push_back(FormatFixed(derivative, 4));
      }
      lines.back().cells.push_back(pair.gradient_kink() ? "yes" : "");
    }
  }
  PrintTable(columns, lines, session.table_style(), session.streams.out);
}

template <class Request, class Response, class Method>
absl::Status EvaluatePairs(Session& session, const PairArguments& arguments, Method method,
                           const Request& form) {
  const auto options = ParseQueryOptions(arguments.query);
  if (!options.ok()) return options.status();
  const auto batches = ReadBatches(arguments.body, session);
  if (!batches.ok()) return batches.status();
  const auto answer = EvaluateBatches<Request, Response>(session, method, *batches, *options, form);
  if (!answer.ok()) return answer.status();
  PrintResult(session, *answer, RowCount(*batches), PrintPairs<Response>);
  return absl::OkStatus();
}

absl::Status EvaluateDistances(Session& session, const PairArguments& arguments) {
  pb::GetDistancesRequest form;
  form.set_pairs(arguments.pairs);
  form.set_want_joint_gradient(arguments.gradient);
  return EvaluatePairs<pb::GetDistancesRequest, pb::GetDistancesResponse>(
      session, arguments, &pb::QueryService::Stub::GetDistances, form);
}

absl::Status EvaluateContacts(Session& session, const PairArguments& arguments) {
  if (!arguments.all) {
    pb::GetContactsRequest form;
    form.set_max_contacts_per_pair(arguments.max_contacts_per_pair);
    return EvaluatePairs<pb::GetContactsRequest, pb::GetContactsResponse>(
        session, arguments, &pb::QueryService::Stub::GetContacts, form);
  }
  if (HasBody(arguments.body)) return UsageError("--all: not together with a body");
  return PrintWorldContacts(session, arguments.query);
}

constexpr char kLines[] =
    "Many questions: JSON lines on stdin, {\"box\": [x, y, z], \"at\": [x, y, z, qx, qy, qz, qw]}; "
    "\"at\"\n"
    "may hold several poses. A robot: {\"robot\": \"panda\", \"group\": \"panda_arm\", "
    "\"joints\": [...]}. With a shape and --at -, each line is {\"at\": ...} or a pose as an "
    "array.\n"
    "All rows are answered from one revision. -o ndjson prints one line a row.";

}  // namespace

void AddPairCommands(CommandLine& line) {
  const auto distance = std::make_shared<PairArguments>();
  CLI::App& distances = AddCommand(
      line,
      {"distance",
       "signed distance to the nearest objects, with points and normal",
       {"cwm distance --box 0.1,0.08,0.2 --at 0.4,0,0.3",
        "cwm distance --object mug --max-results 3",
        "cwm distance --robot panda --group panda_arm --joints 0,-0.8,0,-2.4,0,1.6,0.8",
        "cwm distance --robot panda --joints ready --pairs links --max-distance 0.2 --gradient",
        "printf '[0.4,0,0.3]\\n[0.5,0,0.3]\\n' | cwm distance --sphere 0.05 --at - -o ndjson"},
       kLines},
      [distance](Session& session) { return EvaluateDistances(session, *distance); });
  AddBodyOptions(distances, distance->body);
  AddQueryOptions(distances, distance->query);
  AddPairRuleOptions(distances, distance->query);
  distances
      .add_option("--max-results", distance->query.max_results,
                  "nearest objects a row, default 1; with --pairs links those of each link, "
                  "default all")
      ->type_name("N");
  distances
      .add_option("--pairs", distance->pairs,
                  "objects (default): the nearest objects; links: each link of a robot with each "
                  "object, with links of other robots and with its own")
      ->transform(OneOf(ShortNames<pb::DistancePairs>()))
      ->type_name("objects|links");
  distances.add_flag("--gradient", distance->gradient,
                     "derivatives of a robot's distances by its joints (m/rad, m/m)");

  const auto contact = std::make_shared<PairArguments>();
  CLI::App& contacts = AddCommand(
      line,
      {"contacts",
       "where a body touches or penetrates the world",
       {"cwm contacts --sphere 0.05 --at 0.4,0,0.02", "cwm contacts --object mug --margin 0.005",
        "cwm contacts --robot panda --joints ready --margin 0.01", "cwm contacts --all"},
       kLines},
      [contact](Session& session) { return EvaluateContacts(session, *contact); });
  AddBodyOptions(contacts, contact->body);
  contacts.add_flag("--all", contact->all,
                    "without a body: all pairs of objects and robots of the world");
  AddQueryOptions(contacts, contact->query);
  AddMarginOption(contacts, contact->query);
  AddPairRuleOptions(contacts, contact->query);
  contacts
      .add_option("--max-contacts", contact->query.max_contacts,
                  "points a row; default 16; with --all pairs, default 65536")
      ->type_name("N");
  contacts
      .add_option("--max-contacts-per-pair", contact->max_contacts_per_pair,
                  "points of two parts, the deepest first; default all")
      ->type_name("N");
}

}  // namespace cwm::cli
