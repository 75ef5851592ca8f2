#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "cwm/internal/columns.h"
#include "cwm/internal/query_batches.h"
#include "cwm/world.h"

namespace cwm::CWM_API {
namespace {

using internal::Batches;
using internal::BoundSubject;
using internal::Columns;
using internal::ColumnsOfRows;
using internal::View;

// derived: a row of Contacts holds this many points if none are given.
constexpr std::int64_t kDefaultContacts = 16;

template <class Reply>
std::int64_t CompletedCount(const Reply& reply) {
  return reply.completed_count();
}

// The columns of the pair of each row or motion.
template <class Reply>
void FillPairs(const std::vector<Reply>& replies, const BoundSubject& subject, ResultHead& head,
               PairColumns& pairs) {
  pairs.object_index = internal::FillHead(
      replies, static_cast<Eigen::Index>(subject.batches.unit_count()),
      [](const Reply& r) -> const std::string& { return r.object_index(); }, CompletedCount<Reply>,
      head);
  const Columns<Reply> columns = ColumnsOfRows(replies);
  pairs.body_part = columns.Ints([](const Reply& r) -> auto& { return r.body_part(); });
  pairs.object_part = columns.Ints([](const Reply& r) -> auto& { return r.object_part(); });
}

// What replies about a robot have.
template <class Reply>
void FillBody(const std::vector<Reply>& replies, const BoundSubject& subject, PairColumns& pairs) {
  pairs.robot = subject.message.robot().robot();
  if (replies.empty()) return;
  const Reply& first = replies.front();
  pairs.body_links.assign(first.body_links().begin(), first.body_links().end());
  pairs.body_objects.assign(first.body_objects().begin(), first.body_objects().end());
}

// The variables by which rows are out of limits; a reply without such a row names none.
template <class Reply, class Result>
void FillLimits(const std::vector<Reply>& replies, Result& result) {
  result.variable_index =
      ColumnsOfRows(replies).Ints([](const Reply& r) -> auto& { return r.variable_index(); });
  for (const Reply& reply : replies) {
    if (reply.variables().empty()) continue;
    result.variables.assign(reply.variables().begin(), reply.variables().end());
    return;
  }
}

template <class Reply>
PairResult PairsFrom(const std::vector<Reply>& replies, const BoundSubject& subject) {
  const auto count = [](const Reply& reply) {
    return internal::LastBegin(reply.columns().row_begin());
  };
  PairResult result;
  result.object_index = internal::FillHead(
      replies, static_cast<Eigen::Index>(subject.batches.unit_count()),
      [](const Reply& r) -> auto& { return r.columns().object_index(); }, count, result);
  FillBody(replies, subject, result);
  result.row_begin = internal::JoinRowBegins(
      replies, [](const Reply& r) -> auto& { return r.columns().row_begin(); });
  const Columns<Reply> columns(replies, count);
  result.body_part = columns.Ints([](const Reply& r) -> auto& { return r.columns().body_part(); });
  result.object_part =
      columns.Ints([](const Reply& r) -> auto& { return r.columns().object_part(); });
  result.distance_m =
      columns.Doubles([](const Reply& r) -> auto& { return r.columns().distance_m(); });
  result.point_body =
      columns.Vectors([](const Reply& r) -> auto& { return r.columns().point_body(); });
  result.point_object =
      columns.Vectors([](const Reply& r) -> auto& { return r.columns().point_object(); });
  result.normal = columns.Vectors([](const Reply& r) -> auto& { return r.columns().normal(); });
  result.trust =
      columns.template Bytes<Trust>([](const Reply& r) -> auto& { return r.columns().trust(); });
  result.bound_m = columns.Doubles([](const Reply& r) -> auto& { return r.columns().bound_m(); });
  return result;
}

MotionResult CheckMotions(const View& view, const BoundSubject& subject, bool has_paths,
                          const QueryOptions& options) {
  using Reply = v1::CheckMotionsResponse;
  const Batches& batches = subject.batches;
  const auto replies = internal::Evaluate<v1::CheckMotionsRequest>(
      view, options, subject.meshes, batches,
      [&](v1::CheckMotionsRequest& request, std::int64_t first, std::int64_t end) {
        subject.Fill(first, end, *request.mutable_subject());
        for (std::int64_t i = first; has_paths && i < end; ++i) {
          const auto unit = static_cast<std::size_t>(i);
          request.add_path_row_counts(
              static_cast<std::int32_t>(batches.unit_begin[unit + 1] - batches.unit_begin[unit]));
        }
      });
  MotionResult result;
  FillPairs(replies, subject, result, result);
  FillBody(replies, subject, result);
  FillLimits(replies, result);
  const Columns<Reply> columns = ColumnsOfRows(replies);
  result.verdict =
      columns.Bytes<MotionVerdict>([](const Reply& r) -> auto& { return r.verdicts(); });
  result.segment = columns.Ints([](const Reply& r) -> auto& { return r.segment(); });
  result.lo = columns.Doubles([](const Reply& r) -> auto& { return r.lo(); });
  result.hi = columns.Doubles([](const Reply& r) -> auto& { return r.hi(); });
  result.clearance_m = columns.Doubles([](const Reply& r) -> auto& { return r.clearance_m(); });
  result.trust = columns.Bytes<Trust>([](const Reply& r) -> auto& { return r.trust(); });
  return result;
}

}  // namespace

CheckResult WorldView::Check(const Subject& subject, const Rows& rows,
                             const QueryOptions& options) const {
  using Reply = v1::CheckCollisionsResponse;
  const BoundSubject bound = internal::Bind(subject, rows, "rows");
  const auto replies = internal::Evaluate<v1::CheckCollisionsRequest>(
      view(), options, bound.meshes, bound.batches,
      [&](v1::CheckCollisionsRequest& request, std::int64_t first, std::int64_t end) {
        bound.Fill(first, end, *request.mutable_subject());
      });
  CheckResult result;
  FillPairs(replies, bound, result, result);
  FillBody(replies, bound, result);
  FillLimits(replies, result);
  const Columns<Reply> columns = ColumnsOfRows(replies);
  result.verdict = columns.Bytes<Verdict>([](const Reply& r) -> auto& { return r.verdicts(); });
  result.trust = columns.Bytes<Trust>([](const Reply& r) -> auto& { return r.trust(); });
  return result;
}

PairResult WorldView::Distance(const Subject& subject, const Rows& rows,
                               const QueryOptions& options) const {
  using Reply = v1::GetDistancesResponse;
  BoundSubject bound = internal::Bind(subject, rows, "rows");
  const bool by_links = options.pairs == DistancePairs::kLinks;
  bound.batches.answers_per_unit =
      std::max<std::int64_t>(1, options.max_results) * (by_links ? internal::kManyLinks : 1);
  const auto replies = internal::Evaluate<v1::GetDistancesRequest>(
      view(), options, bound.meshes, bound.batches,
      [&](v1::GetDistancesRequest& request, std::int64_t first, std::int64_t end) {
        bound.Fill(first, end, *request.mutable_subject());
        request.set_pairs(static_cast<v1::DistancePairs>(options.pairs));
        request.set_want_joint_gradient(options.joint_gradient);
      });
  PairResult result = PairsFrom(replies, bound);
  if (!options.joint_gradient || replies.empty()) return result;
  const auto& variables = replies.front().variables();
  result.variables.assign(variables.begin(), variables.end());
  const Columns<Reply> columns(
      replies, [](const Reply& r) { return internal::LastBegin(r.columns().row_begin()); });
  result.joint_gradient = columns.Matrix(
      [](const Reply& r) -> auto& { return r.columns().joint_gradient(); },
      static_cast<Eigen::Index>(variables.size()));
  result.gradient_kink =
      columns.Bools([](const Reply& r) -> auto& { return r.columns().gradient_kink(); });
  return result;
}

PairResult WorldView::Contacts(const Subject& subject, const Rows& rows,
                               const QueryOptions& options) const {
  BoundSubject bound = internal::Bind(subject, rows, "rows");
  bound.batches.answers_per_unit =
      options.max_contacts > 0 ? options.max_contacts : kDefaultContacts;
  return PairsFrom(internal::Evaluate<v1::GetContactsRequest>(
                       view(), options, bound.meshes, bound.batches,
                       [&](v1::GetContactsRequest& request, std::int64_t first, std::int64_t end) {
                         bound.Fill(first, end, *request.mutable_subject());
                         request.set_max_contacts_per_pair(options.max_contacts_per_pair);
                       }),
                   bound);
}

WorldContacts WorldView::ContactsOfWorld(const QueryOptions& options) const {
  using Reply = v1::GetWorldContactsResponse;
  std::vector<internal::MeshBlob> meshes;
  v1::GetWorldContactsRequest request;
  request.set_world(view().world);
  *request.mutable_options() = internal::OptionsOf(view(), options, meshes);
  internal::SetRevision(view(), *request.mutable_options());
  const std::vector<Reply> replies = {
      internal::WithMeshes(view(), meshes, [&] { return internal::Ask(view(), request); })};
  const Reply& reply = replies.front();
  WorldContacts result{.world_uid = reply.world_uid(),
                       .revision = reply.revision(),
                       .is_complete = reply.is_complete()};
  for (const v1::ObjectRef& object : reply.objects()) {
    result.objects.push_back(internal::FromMessage(object));
  }
  const Columns<Reply> columns(
      replies, [](const Reply& r) { return r.distance_m().size() / sizeof(double); });
  result.object_a = columns.Ints([](const Reply& r) -> auto& { return r.object_a(); });
  result.object_b = columns.Ints([](const Reply& r) -> auto& { return r.object_b(); });
  result.part_a = columns.Ints([](const Reply& r) -> auto& { return r.part_a(); });
  result.part_b = columns.Ints([](const Reply& r) -> auto& { return r.part_b(); });
  result.distance_m = columns.Doubles([](const Reply& r) -> auto& { return r.distance_m(); });
  result.point_a = columns.Vectors([](const Reply& r) -> auto& { return r.point_a(); });
  result.point_b = columns.Vectors([](const Reply& r) -> auto& { return r.point_b(); });
  result.normal = columns.Vectors([](const Reply& r) -> auto& { return r.normal(); });
  result.trust = columns.Bytes<Trust>([](const Reply& r) -> auto& { return r.trust(); });
  result.bound_m = columns.Doubles([](const Reply& r) -> auto& { return r.bound_m(); });
  return result;
}

MotionResult WorldView::Motions(const Subject& subject, const Rows& starts, const Rows& ends,
                                const QueryOptions& options) const {
  BoundSubject bound = internal::Bind(subject, starts, "starts");
  const BoundSubject last = internal::Bind(subject, ends, "ends");
  const Batches &from = bound.batches, &to = last.batches;
  if (from.width != to.width || from.numbers.size() != to.numbers.size()) {
    internal::ThrowBadArgument(
        "ends", absl::StrCat("are ", to.row_count(), " of ", to.width, " numbers, must be ",
                             from.row_count(), " of ", from.width, " as the starts"));
  }
  Batches both{.numbers = {}, .width = from.width, .unit_begin = {0}};
  both.numbers.reserve(2 * from.numbers.size());
  for (std::size_t begin = 0; begin < from.numbers.size(); begin += from.width) {
    for (const Batches* rows : {&from, &to}) {
      const auto row = rows->numbers.begin() + static_cast<std::ptrdiff_t>(begin);
      both.numbers.insert(both.numbers.end(), row, row + static_cast<std::ptrdiff_t>(from.width));
    }
    both.unit_begin.push_back(both.unit_begin.back() + 2);
  }
  bound.batches = std::move(both);
  return CheckMotions(view(), bound, /*has_paths=*/false, options);
}

MotionResult WorldView::Paths(const Subject& subject, std::span<const Rows> paths,
                              const QueryOptions& options) const {
  if (paths.empty()) internal::ThrowBadArgument("paths", "are none, must be at least one");
  BoundSubject all;
  Batches& joined = all.batches;
  joined.unit_begin = {0};
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const std::string name = absl::StrCat("paths[", i, "]");
    BoundSubject bound = internal::Bind(subject, paths[i], name);
    const Batches& rows = bound.batches;
    if (rows.row_count() < 2) {
      internal::ThrowBadArgument(
          name, absl::StrCat("has ", rows.row_count(), " rows, must have at least 2"));
    }
    if (i > 0 && rows.width != joined.width) {
      internal::ThrowBadArgument(
          name, absl::StrCat("has rows of ", rows.width, " numbers, must have ", joined.width,
                             " as paths[0]"));
    }
    joined.width = rows.width;
    joined.numbers.insert(joined.numbers.end(), rows.numbers.begin(), rows.numbers.end());
    joined.unit_begin.push_back(joined.unit_begin.back() + rows.row_count());
    if (i > 0) continue;
    all.message = std::move(bound.message);
    all.meshes = std::move(bound.meshes);
  }
  return CheckMotions(view(), all, /*has_paths=*/true, options);
}

MotionResult WorldView::Path(const Subject& subject, const Rows& path,
                             const QueryOptions& options) const {
  return Paths(subject, {&path, 1}, options);
}

RayResult WorldView::Rays(const Eigen::Ref<const Eigen::Matrix3Xd>& origins,
                          const Eigen::Ref<const Eigen::Matrix3Xd>& directions,
                          const QueryOptions& options) const {
  using Reply = v1::CastRaysResponse;
  if (origins.cols() != directions.cols() && origins.cols() != 1) {
    internal::ThrowBadArgument(
        "origins", absl::StrCat("are ", origins.cols(), ", must be 1 or one for each of ",
                                directions.cols(), " directions"));
  }
  constexpr std::size_t kRayWidth = 6;
  std::vector<double> numbers;
  numbers.reserve(kRayWidth * static_cast<std::size_t>(directions.cols()));
  for (Eigen::Index i = 0; i < directions.cols(); ++i) {
    const Eigen::Vector3d origin = origins.col(origins.cols() == 1 ? 0 : i);
    const Eigen::Vector3d direction = directions.col(i);
    numbers.insert(numbers.end(), origin.data(), origin.data() + 3);
    numbers.insert(numbers.end(), direction.data(), direction.data() + 3);
  }
  const Batches batches = internal::BatchesOfRows(std::move(numbers), kRayWidth);
  const auto replies = internal::Evaluate<v1::CastRaysRequest>(
      view(), options, {}, batches,
      [&](v1::CastRaysRequest& request, std::int64_t first, std::int64_t end) {
        request.mutable_rays()->set_data(batches.Bytes(first, end));
      });
  RayResult result;
  result.object_index = internal::FillHead(
      replies, directions.cols(), [](const Reply& r) -> auto& { return r.object_index(); },
      CompletedCount<Reply>, result);
  const Columns<Reply> columns = ColumnsOfRows(replies);
  result.hit = columns.Bools([](const Reply& r) -> auto& { return r.hit(); });
  result.distance_m = columns.Doubles([](const Reply& r) -> auto& { return r.distance_m(); });
  result.normal = columns.Vectors([](const Reply& r) -> auto& { return r.normal(); });
  result.object_part = columns.Ints([](const Reply& r) -> auto& { return r.object_part(); });
  result.trust = columns.Bytes<Trust>([](const Reply& r) -> auto& { return r.trust(); });
  return result;
}

SampleResult WorldView::Sample(const Eigen::Ref<const Eigen::Matrix3Xd>& points,
                               const QueryOptions& options) const {
  using Reply = v1::SamplePointsResponse;
  const Eigen::Matrix3Xd dense = points;
  const Batches batches = internal::BatchesOfRows({dense.data(), dense.data() + dense.size()}, 3);
  const auto replies = internal::Evaluate<v1::SamplePointsRequest>(
      view(), options, {}, batches,
      [&](v1::SamplePointsRequest& request, std::int64_t first, std::int64_t end) {
        request.mutable_points()->set_data(batches.Bytes(first, end));
      });
  SampleResult result;
  result.object_index = internal::FillHead(
      replies, points.cols(), [](const Reply& r) -> auto& { return r.object_index(); },
      CompletedCount<Reply>, result);
  const Columns<Reply> columns = ColumnsOfRows(replies);
  result.state = columns.Bytes<SampleState>([](const Reply& r) -> auto& { return r.state(); });
  result.distance_m = columns.Doubles([](const Reply& r) -> auto& { return r.distance_m(); });
  result.gradient = columns.Vectors([](const Reply& r) -> auto& { return r.gradient(); });
  result.object_part = columns.Ints([](const Reply& r) -> auto& { return r.object_part(); });
  result.trust = columns.Bytes<Trust>([](const Reply& r) -> auto& { return r.trust(); });
  result.bound_m = columns.Doubles([](const Reply& r) -> auto& { return r.bound_m(); });
  return result;
}

}  // namespace cwm::CWM_API
