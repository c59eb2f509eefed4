/* Who owns a part, as a protocol: a server that crashes and comes back, three sites that ask, publish, let go, pause and
 * are engaged beside an owner, leases that run out, records in order, state datagrams lost, doubled and in any order.
 * sync/replica/ownership_table.h and ownership_view.h state the rules;
 * ownership_model_test.cpp runs the code itself through random histories.
 *
 * Time goes in ticks that all clocks take together; a site ends its lease a tick before the server does. Every event is
 * one step, so that a search of N steps is one of histories of N events, in any order. check_protocol.py searches all
 * histories of 11 events of a part and of 9 events of two parts, and samples longer ones.
 *
 * One of these macros breaks one rule, and an assertion must fail:
 *   EPOCH_IN_MEMORY  a crash forgets epochs                   S1
 *   NO_EPOCH_CHECK   sites show states of any epoch           S2
 *   EARLY_REGRANT    the server frees a part two ticks early  S3
 *   NO_RECLAIM       a pong revives a lease that had lapsed   S3
 *   NO_HEIR          a part is freed while sites simulate it  S5
 *   NO_RECOVERY      a restarted server grants at once        S8
 */
#ifndef PARTS
#define PARTS 2
#endif
#define SITES 3
#define LEASE 3
#define MOST_EPOCHS 3
#define NOBODY 0
#ifdef EARLY_REGRANT
#define SERVER_LEASE 1
#else
#define SERVER_LEASE LEASE
#endif

/* The server: what it remembers, and what its journal keeps. */
bool up = true, crashed = false;
byte owner[PARTS], epoch[PARTS], lease[PARTS];
byte engaged[PARTS]; /* a bit a site: 2, 4, 8 */
byte keptOwner[PARTS], keptEpoch[PARTS];
bool awaited[PARTS];
byte recovering; /* ticks */

/* The sites, from 1. */
typedef Site {
  byte owner[PARTS];
  byte epoch[PARTS];
  bool unconfirmed[PARTS];
  bool heir[PARTS]; /* confirmed as a co-holder by an answer to a request since its lease last lapsed */
  byte stale;       /* records still to be read that are older than the last lapse */
  byte shown[PARTS]; /* epoch of the last state shown */
  byte lease = LEASE - 1;
  byte ping, pingAge; /* ping: 0 none, 1 under way, 2 answered */
  bool connected = true;
  bool paused;
};
Site site[SITES + 1];

/* What the server tells each site, in order: a part's record (part, epoch, owner), or that it is engaged in the part. */
#define CHANGED 0 /* a record */
#define GRANTED 1 /* a record that answers the site's own request */
#define ENGAGED 2
chan sent[SITES + 1] = [2] of { byte, byte, byte, byte };

/* A state datagram that the network keeps as long as it likes and delivers as often. */
byte flyingPart, flyingEpoch, flyingFrom;
bool flying, relayed;

/* What happened, for the assertions. */
byte highest[PARTS]; /* epoch granted */
byte ended[PARTS];   /* the last epoch that the server ended because its lease ran out */

/* Of one step; 0 between steps. */
byte n, q, e, o, kind;

#define AWAITS (recovering > 0 && (awaited[0] || awaited[PARTS - 1]))
#ifdef NO_RECOVERY
#define MAY_GRANT true
#else
#define MAY_GRANT !AWAITS
#endif
#ifdef EPOCH_IN_MEMORY
#define KEPT_EPOCH 0
#define KEPT_OWNER NOBODY
#else
#define KEPT_EPOCH keptEpoch[n]
#define KEPT_OWNER keptOwner[n]
#endif
#ifdef NO_RECLAIM
#define LAPSED false
#else
#define LAPSED (site[ME].lease == 0)
#endif
#ifdef NO_HEIR
#define MAY_INHERIT false
#else
#define MAY_INHERIT (epoch[PART] < MOST_EPOCHS)
#endif
#ifdef NO_EPOCH_CHECK
#define TAKES true
#else
#define TAKES (site[ME].epoch[flyingPart] == flyingEpoch && site[ME].owner[flyingPart] == flyingFrom)
#endif

/* One process for each site and part: what concerns no part is done by that of part 0. */
#define ME (_pid % SITES + 1)
#define PART (_pid / SITES)
#define PRESENT(s) (site[s].connected && !site[s].paused)
#define ACTS PRESENT(ME)
#define OWNS (site[ME].owner[PART] == ME && site[ME].epoch[PART] > 0)
/* Sites and parts are alike: whoever is first to get a part may as well be called 1, and the part 0. */
#define MAY_BE_FIRST (highest[0] > 0 || (ME == 1 && PART == 0))
/* Whom the server still knows to own the part, and what the site knows of that. */
#define SIMULATES(s) (engaged[PART] & (1 << (s)))
#define LETS_GO(s) (PRESENT(s) && site[s].owner[PART] == s && owner[PART] == s && epoch[PART] == site[s].epoch[PART])
#define RUNS_OUT (owner[PART] != NOBODY && lease[PART] <= LEASE - SERVER_LEASE)
#define SOMEBODY_PRESENT_ENGAGED \
  ((SIMULATES(1) && PRESENT(1)) || (SIMULATES(2) && PRESENT(2)) || (SIMULATES(3) && PRESENT(3)))

/* A site whose records do not fit is cut off, and comes back to hear how things stand. */
inline tell(x, who) {
  n = 1;
  do
  :: n <= SITES ->
    if
    :: site[n].connected && len(sent[n]) < 2 -> sent[n]!x, epoch[x], owner[x], (n == who -> GRANTED : CHANGED)
    :: site[n].connected && len(sent[n]) == 2 -> cut(n)
    :: else -> skip
    fi;
    n++
  :: else -> break
  od;
  n = 0
}
inline cut(s) {
  do
  :: len(sent[s]) > 0 -> sent[s]?_, _, _, _
  :: else -> break
  od;
  site[s].connected = false;
  site[s].ping = 0;
  site[s].pingAge = 0;
  site[s].stale = 0
}
inline begin(x, s) {
  epoch[x]++;
  owner[x] = s;
  lease[x] = LEASE;
  engaged[x] = engaged[x] & (15 - (1 << s));
  assert(epoch[x] > highest[x]); /* S1 */
  highest[x] = epoch[x];
  keptOwner[x] = s;
  keptEpoch[x] = epoch[x]
}
/* The owner's time is over. Only without anybody who simulates the part beside that one may it be nobody's. */
inline free(x) {
  assert(engaged[x] == 0 || epoch[x] == MOST_EPOCHS); /* S5 */
  awaited[x] = false;
  owner[x] = NOBODY;
  lease[x] = 0;
  keptOwner[x] = NOBODY;
  tell(x, 0)
}
inline inherit(x, s) {
  awaited[x] = false;
  begin(x, s);
  tell(x, 0)
}
/* A site whose pings stopped is no co-holder any more when a lease expires. */
inline end_lease(x) {
  ended[x] = epoch[x];
  n = 1;
  do
  :: n <= SITES ->
    if
    :: !PRESENT(n) -> engaged[x] = engaged[x] & (15 - (1 << n))
    :: else -> skip
    fi;
    n++
  :: else -> break
  od;
  n = 0
}
/* A record at a site. */
inline apply(s, x, itsEpoch, itsOwner, confirmed) {
  if
  :: itsEpoch > site[s].epoch[x] || (itsEpoch == site[s].epoch[x] && itsOwner == NOBODY) ->
    if
    :: itsEpoch > site[s].epoch[x] ->
      site[s].shown[x] = itsEpoch;
      site[s].unconfirmed[x] = !(confirmed || site[s].heir[x]);
      site[s].heir[x] = false
    :: else -> skip
    fi;
    site[s].epoch[x] = itsEpoch;
    site[s].owner[x] = itsOwner
  :: else -> skip
  fi
}

active [SITES * PARTS] proctype OfASiteAndAPart() {
  do
  /* The site asks for the part, and the server decides. */
  :: d_step {
      up && ACTS && epoch[PART] < MOST_EPOCHS && owner[PART] == NOBODY && MAY_GRANT && MAY_BE_FIRST ->
      assert(!AWAITS); /* S8 */
      begin(PART, ME);
      tell(PART, ME)
    }
  /* It lets go; nobody has the part, or somebody who simulates it too: any of them here, the longest engaged in fact. */
  :: d_step { up && OWNS && LETS_GO(ME) && !(engaged[PART] != 0 && MAY_INHERIT) -> free(PART) }
  :: d_step {
      up && owner[PART] != NOBODY && owner[PART] != ME && LETS_GO(owner[PART]) && SIMULATES(ME) && MAY_INHERIT ->
      inherit(PART, ME)
    }
  /* The lease of the part's owner runs out, likewise. */
  :: d_step {
      up && ME == 1 && RUNS_OUT && !(SOMEBODY_PRESENT_ENGAGED && MAY_INHERIT) -> end_lease(PART); free(PART)
    }
  :: d_step { up && RUNS_OUT && SIMULATES(ME) && ACTS && MAY_INHERIT -> end_lease(PART); inherit(PART, ME) }
  /* It is engaged in what another one owns, or no longer. */
  :: d_step {
      up && ACTS && owner[PART] != NOBODY && owner[PART] != ME && !OWNS && len(sent[ME]) < 2 ->
      engaged[PART] = engaged[PART] | (1 << ME);
      sent[ME]!PART, 0, 0, ENGAGED
    }
  :: d_step { up && ACTS && SIMULATES(ME) -> engaged[PART] = engaged[PART] & (15 - (1 << ME)) }
  /* What it holds over a lapse it asks for again. */
  :: d_step {
      up && ACTS && OWNS && site[ME].unconfirmed[PART] && owner[PART] == ME && epoch[PART] == site[ME].epoch[PART] &&
        len(sent[ME]) == 0 ->
      site[ME].unconfirmed[PART] = false;
      lease[PART] = LEASE;
      awaited[PART] = false
    }
  /* It publishes a state. */
  :: d_step {
      ACTS && OWNS && site[ME].lease > 0 && !site[ME].unconfirmed[PART] ->
      assert(ended[PART] < site[ME].epoch[PART]); /* S3 */
      flying = true;
      relayed = false;
      flyingPart = PART;
      flyingEpoch = site[ME].epoch[PART];
      flyingFrom = ME
    }

  /* It is shown one. */
  :: d_step {
      PART == 0 && flying && relayed && site[ME].connected && ME != flyingFrom && TAKES ->
      assert(flyingEpoch >= site[ME].shown[flyingPart]); /* S2 */
      site[ME].shown[flyingPart] = flyingEpoch
    }
  /* Records arrive in order. */
  :: d_step {
      PART == 0 && site[ME].connected && len(sent[ME]) > 0 ->
      sent[ME]?q, e, o, kind;
      if
      :: kind == ENGAGED -> site[ME].heir[q] = (site[ME].heir[q] || site[ME].stale == 0)
      :: else -> apply(ME, q, e, o, kind == GRANTED && site[ME].stale == 0)
      fi;
      if
      :: site[ME].stale > 0 -> site[ME].stale--
      :: else -> skip
      fi;
      q = 0; e = 0; o = 0; kind = 0
    }
  /* Pings, lost or not. */
  :: d_step { PART == 0 && ACTS && site[ME].ping == 0 -> site[ME].ping = 1; site[ME].pingAge = 0 }
  :: d_step {
      PART == 0 && up && site[ME].ping == 1 ->
      site[ME].ping = 2;
      do
      :: n < PARTS ->
        if
        :: owner[n] == ME -> lease[n] = LEASE
        :: else -> skip
        fi;
        n++
      :: else -> break
      od;
      n = 0
    }
  :: d_step { PART == 0 && site[ME].ping > 0 -> site[ME].ping = 0; site[ME].pingAge = 0 }
  :: d_step {
      PART == 0 && ACTS && site[ME].ping == 2 ->
      do
      :: n < PARTS ->
        if
        :: LAPSED ->
          site[ME].unconfirmed[n] = true;
          site[ME].heir[n] = false;
          site[ME].stale = len(sent[ME])
        :: else -> skip
        fi;
        n++
      :: else -> break
      od;
      n = 0;
      if
      :: LEASE - 1 > site[ME].pingAge && LEASE - 1 - site[ME].pingAge > site[ME].lease ->
        site[ME].lease = LEASE - 1 - site[ME].pingAge
      :: else -> skip
      fi;
      site[ME].ping = 0;
      site[ME].pingAge = 0
    }
  /* It pauses, for as long as it likes, or its connection breaks; it comes back and gets the present records. */
  :: d_step { PART == 0 -> site[ME].paused = !site[ME].paused }
  :: d_step { PART == 0 && site[ME].connected -> cut(ME) }
  :: d_step {
      PART == 0 && up && !site[ME].connected && !site[ME].paused ->
      site[ME].connected = true;
      do
      :: n < PARTS ->
        apply(ME, n, epoch[n], owner[n], false);
        if
        :: site[ME].owner[n] == ME && owner[n] == ME ->
          awaited[n] = false;
          lease[n] = LEASE;
          site[ME].unconfirmed[n] = false
        :: else -> skip
        fi;
        n++
      :: else -> break
      od;
      n = 0
    }
  od
}

active proctype Server() {
  do
  /* A state is passed on. */
  :: d_step {
      up && flying && !relayed && owner[flyingPart] == flyingFrom && epoch[flyingPart] == flyingEpoch ->
      relayed = true;
      awaited[flyingPart] = false
    }
  /* It dies once, and comes back with its journal. */
  :: d_step {
      up && !crashed ->
      up = false;
      crashed = true;
      q = 1;
      do
      :: q <= SITES -> cut(q); q++
      :: else -> break
      od;
      q = 0
    }
  :: d_step {
      !up ->
      up = true;
      recovering = LEASE;
      do
      :: n < PARTS ->
        epoch[n] = KEPT_EPOCH;
        owner[n] = KEPT_OWNER;
        lease[n] = LEASE;
        engaged[n] = 0;
        awaited[n] = owner[n] != NOBODY;
        n++
      :: else -> break
      od;
      n = 0
    }
  od
}

active proctype Time() {
  do
  :: d_step {
      n = 1;
      do
      :: n <= SITES ->
        if
        :: site[n].lease > 0 -> site[n].lease--
        :: else -> skip
        fi;
        if
        :: site[n].ping > 0 && site[n].pingAge < LEASE -> site[n].pingAge++
        :: else -> skip
        fi;
        n++
      :: else -> break
      od;
      n = 0;
      do
      :: n < PARTS ->
        if
        :: lease[n] > 0 -> lease[n]--
        :: else -> skip
        fi;
        n++
      :: else -> break
      od;
      n = 0;
      if
      :: recovering > 0 -> recovering--
      :: else -> skip
      fi
    }
  od
}
