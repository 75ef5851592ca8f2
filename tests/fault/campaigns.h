// The campaigns: each breaks stores in its own way until its count is reached or its time is over.
#pragma once

#include "tests/fault/campaign.h"

namespace cwm::fault {

// SIGKILL at random times and at each failpoint in turn. Counts "kills".
void RunKills(Campaign& campaign);

// Power cuts of a file system on a loop device. Counts "cuts". False, with a reason on stderr, if
// that cannot be done here.
bool RunCuts(Campaign& campaign);

// Disks that are full or fail. Counts "disks".
void RunDisks(Campaign& campaign);

// One flipped bit in a file of a small store. Counts "flips".
void RunFlips(Campaign& campaign);

// Short histories with kills, pauses, full disks and orderly restarts. Counts "histories".
void RunHistories(Campaign& campaign);

}  // namespace cwm::fault
