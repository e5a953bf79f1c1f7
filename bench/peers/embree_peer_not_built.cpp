// Stands in where Embree is not installed.
// SPDX-License-Identifier: MPL-2.0
#include "peers/peers.h"

namespace isocast {

PeerFrame embree_peer(const PeerScene&) {
    return {.name = "mesh on Embree", .note = "not built (package libembree-dev)"};
}

} // namespace isocast
