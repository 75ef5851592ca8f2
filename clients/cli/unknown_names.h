// Names that nothing has. Where a question leaves things out, or a rule is about things that may come later,
// the server takes them; what was mistyped would go unnoticed.
#pragma once

#include <string>
#include <vector>

#include "clients/cli/session.h"
#include "cwm/v1/query.pb.h"

namespace cwm::cli {

// Warns of each name to ignore, alone or in pairs, that no object or robot of the world has.
void WarnOfUnknownNames(Session& session, const cwm::v1::QueryOptions& options);

// Warns of names that nothing has while something has a similar one: a rule may be about what comes
// later.
void WarnOfUnknownNames(Session& session, const cwm::v1::NamedPair& pair);

// Warns of each link that the robot does not have; of none where there is no such robot.
void WarnOfUnknownLinks(Session& session, const std::string& robot,
                        const std::vector<std::string>& links);

}  // namespace cwm::cli
