#pragma once

// Any control message. Control messages travel in order and without loss. sync/WIRE.md numbers their kinds by
// their place here.

#include <variant>

#include "sync/wire/admission_messages.h"
#include "sync/wire/command_messages.h"
#include "sync/wire/document_messages.h"
#include "sync/wire/doubt_messages.h"
#include "sync/wire/ownership_messages.h"
#include "sync/wire/participant_messages.h"
#include "sync/wire/presentation_messages.h"
#include "sync/wire/report_messages.h"
#include "sync/wire/scene_messages.h"

namespace tandem::sync {

/// A kind that no message has. Its bytes are refused.
struct Unassigned {};

using ControlMessage =
    std::variant<Hello, SceneRequest, Ready, Grab, Release, Reclaim, Revoke, ResetParts, Goodbye, Welcome,
                 Refused, SceneChunk, SiteChanged, SiteLeft, GrabReply, ReleaseReply, CommandReply,
                 OwnershipChanged, Engage, Disengage, EngageReply, MembersChanged, NewTicket, SiteReport,
                 Unassigned, Unassigned, PutEntry, PutReply, DocumentChanged, DocumentRequest, DocumentChunk,
                 Presentation, Say, Doubt, Said>;

}  // namespace tandem::sync
