// Warns of names that do not exist. Ignored names and pair rules may refer to future objects, so
// the server accepts unknown names, and typing errors would go unnoticed.
#pragma once

#include <string>
#include <vector>

#include "clients/cli/session.h"
#include "cwm/v1/query.pb.h"

namespace cwm::cli {

// Warns of each ignored name, alone or in pairs, that no object or robot of the world has.
void WarnAboutUnknownNames(Session& session, const cwm::v1::QueryOptions& options);

// Warns of unknown names only if a similar name exists, since a rule may be about future objects.
void WarnAboutUnknownNames(Session& session, const cwm::v1::NamedPair& pair);

// Warns of each link that the robot does not have; does nothing if there is no such robot.
void WarnAboutUnknownLinks(Session& session, const std::string& robot,
                           const std::vector<std::string>& links);

}  // namespace cwm::cli
