/* Who owns a part, as a protocol: a server that crashes and comes back, three sites that ask, publish, let go, pause and
 * are engaged beside an owner, leases that run out, records in order, state datagrams lost, doubled and in any order.
 * sync/ownership.h says the rules; ownership_model_test.cpp runs the code itself through random histories.
 *
 * Time goes in ticks that all clocks take together; a site ends its lease a tick before the server does. All that happens
 * is one of the choices of the loop at the end, in any order.
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

/* The sites, 1 to 3. */
typedef Site {
  byte owner[PARTS];
  byte epoch[PARTS];
  bool unconfirmed[PARTS];
  bool heir[PARTS]; /* engaged in the part, and heard of ever since */
  byte stale;       /* records still to be read that are older than the last lapse */
  byte shown[PARTS]; /* epoch of the last state shown */
  byte lease, ping, pingAge; /* ping: 0 none, 1 under way, 2 answered */
  bool connected, paused;
};
Site site[4];

/* Records to each site, in order. */
/* part, epoch, owner, and whether it answers the site's own request */
chan told[4] = [2] of { byte, byte, byte, bool };

/* A state datagram that the network keeps as long as it likes and delivers as often. */
byte flyingPart, flyingEpoch, flyingFrom;
bool flying, relayed;

/* What happened, for the assertions. */
byte highest[PARTS]; /* epoch granted */
byte ended[PARTS];   /* the last epoch that the server ended because its lease ran out */

byte c, p, n, q, e, o; /* of the present step */
bool answers;

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
#define LAPSED (site[c].lease == 0)
#endif
#ifdef NO_HEIR
#define HEIRS false
#else
#define HEIRS (engaged[q] != 0 && epoch[q] < MOST_EPOCHS)
#endif
#ifdef NO_EPOCH_CHECK
#define TAKES true
#else
#define TAKES (site[c].epoch[flyingPart] == flyingEpoch && site[c].owner[flyingPart] == flyingFrom)
#endif
#define ACTS (site[c].connected && !site[c].paused)
#define OWNS (site[c].owner[p] == c && site[c].epoch[p] > 0)

/* A site whose records do not fit is cut off, and comes back to hear how things stand. */
inline tell(x, who) {
  n = 1;
  do
  :: n <= 3 ->
    if
    :: site[n].connected && len(told[n]) < 2 -> told[n]!x, epoch[x], owner[x], n == who
    :: site[n].connected && len(told[n]) == 2 -> cut(n)
    :: else -> skip
    fi;
    n++
  :: else -> break
  od
}
inline cut(s) {
  site[s].connected = false;
  site[s].ping = 0;
  site[s].stale = 0;
  do
  :: len(told[s]) > 0 -> told[s]?_, _, _, _
  :: len(told[s]) == 0 -> break
  od
}
inline begin(q, s) {
  epoch[q]++;
  owner[q] = s;
  lease[q] = LEASE;
  engaged[q] = engaged[q] & (15 - (1 << s));
  assert(epoch[q] > highest[q]); /* S1 */
  highest[q] = epoch[q];
  keptOwner[q] = s;
  keptEpoch[q] = epoch[q];
}
/* The owner's time is over: who simulates the part beside that one has it next, else nobody. */
inline pass(q) {
  awaited[q] = false;
  owner[q] = NOBODY;
  if
  :: HEIRS ->
    if
    :: engaged[q] & 2 -> begin(q, 1)
    :: engaged[q] & 4 -> begin(q, 2)
    :: engaged[q] & 8 -> begin(q, 3)
    fi
  :: else ->
    keptOwner[q] = NOBODY;
    assert(engaged[q] == 0 || epoch[q] == MOST_EPOCHS) /* S5 */
  fi;
  tell(q, 0)
}
/* A record at a site. */
inline apply(s, q, e, o, confirmed) {
  if
  :: e > site[s].epoch[q] || (e == site[s].epoch[q] && o == NOBODY) ->
    if
    :: e > site[s].epoch[q] ->
      site[s].shown[q] = e;
      site[s].unconfirmed[q] = !(confirmed || site[s].heir[q]);
      site[s].heir[q] = false
    :: else -> skip
    fi;
    site[s].epoch[q] = e;
    site[s].owner[q] = o
  :: else -> skip
  fi
}

init {
  d_step {
    c = 1;
    do
    :: c <= 3 -> site[c].connected = true; site[c].lease = LEASE - 1; c++
    :: else -> break
    od;
    c = 0
  }
  do
  :: atomic {
    /* Which site, which part, and what happens. */
    if :: c = 1 :: c = 2 :: c = 3 fi;
    if :: p = 0 :: p = PARTS - 1 fi;
    if

  /* Time. */
  :: true ->
      n = 1;
      do
      :: n <= 3 ->
        if :: site[n].lease > 0 -> site[n].lease-- :: else -> skip fi;
        if :: site[n].ping > 0 && site[n].pingAge < LEASE -> site[n].pingAge++ :: else -> skip fi;
        n++
      :: else -> break
      od;
      n = 0;
      do
      :: n < PARTS ->
        if :: lease[n] > 0 -> lease[n]-- :: else -> skip fi;
        n++
      :: else -> break
      od;
      if :: recovering > 0 -> recovering-- :: else -> skip fi

  /* A site asks for a part, and the server decides. */
  :: up && ACTS && epoch[p] < MOST_EPOCHS && owner[p] == NOBODY && MAY_GRANT ->
      assert(!AWAITS); /* S8 */
      begin(p, c);
      tell(p, c)
  /* It lets go. */
  :: up && ACTS && OWNS && owner[p] == c && epoch[p] == site[c].epoch[p] -> pass(p)
  /* It is engaged in what another one owns, or no longer. */
  :: up && ACTS && owner[p] != NOBODY && owner[p] != c && !OWNS ->
      engaged[p] = engaged[p] | (1 << c);
      site[c].heir[p] = true
  :: up && ACTS && (engaged[p] & (1 << c)) ->
      engaged[p] = engaged[p] & (15 - (1 << c));
      site[c].heir[p] = false
  /* A lease runs out; who has not been heard of meanwhile simulates nothing any more. */
  :: up && owner[p] != NOBODY && lease[p] <= LEASE - SERVER_LEASE ->
      ended[p] = epoch[p];
      n = 1;
      do
      :: n <= 3 ->
        if :: site[n].paused || !site[n].connected -> engaged[p] = engaged[p] & (15 - (1 << n)) :: else -> skip fi;
        n++
      :: else -> break
      od;
      pass(p)

  /* Pings, lost or not. */
  :: ACTS && site[c].ping == 0 -> site[c].ping = 1; site[c].pingAge = 0
  :: up && site[c].ping == 1 ->
      site[c].ping = 2;
      n = 0;
      do
      :: n < PARTS ->
        if :: owner[n] == c -> lease[n] = LEASE :: else -> skip fi;
        n++
      :: else -> break
      od
  :: site[c].ping > 0 -> site[c].ping = 0; site[c].pingAge = 0
  :: ACTS && site[c].ping == 2 ->
      n = 0;
      do
      :: n < PARTS ->
        if
        :: LAPSED ->
          site[c].unconfirmed[n] = true;
          site[c].heir[n] = false;
          site[c].stale = len(told[c])
        :: else -> skip
        fi;
        n++
      :: else -> break
      od;
      if
      :: LEASE - 1 > site[c].pingAge && LEASE - 1 - site[c].pingAge > site[c].lease ->
        site[c].lease = LEASE - 1 - site[c].pingAge
      :: else -> skip
      fi;
      site[c].ping = 0;
      site[c].pingAge = 0
  /* What it holds over a lapse it asks for again. */
  :: up && ACTS && OWNS && site[c].unconfirmed[p] && owner[p] == c && epoch[p] == site[c].epoch[p] &&
      len(told[c]) == 0 -> site[c].unconfirmed[p] = false; lease[p] = LEASE; awaited[p] = false

  /* Records arrive in order. */
  :: site[c].connected && len(told[c]) > 0 ->
      told[c]?q, e, o, answers;
      apply(c, q, e, o, answers && site[c].stale == 0);
      if :: site[c].stale > 0 -> site[c].stale-- :: else -> skip fi

  /* States. */
  :: ACTS && OWNS && site[c].lease > 0 && !site[c].unconfirmed[p] ->
      assert(ended[p] < site[c].epoch[p]); /* S3 */
      flying = true;
      relayed = false;
      flyingPart = p;
      flyingEpoch = site[c].epoch[p];
      flyingFrom = c
  :: up && flying && !relayed && owner[flyingPart] == flyingFrom && epoch[flyingPart] == flyingEpoch ->
      relayed = true;
      awaited[flyingPart] = false
  :: flying && relayed && site[c].connected && c != flyingFrom && TAKES ->
      assert(flyingEpoch >= site[c].shown[flyingPart]); /* S2 */
      site[c].shown[flyingPart] = flyingEpoch

  /* A site pauses, for as long as it likes, or its connection breaks; it comes back and is told how things stand. */
  :: !site[c].paused -> site[c].paused = true
  :: site[c].paused -> site[c].paused = false
  :: site[c].connected -> cut(c)
  :: up && !site[c].connected && !site[c].paused ->
      site[c].connected = true;
      n = 0;
      do
      :: n < PARTS ->
        apply(c, n, epoch[n], owner[n], false);
        if
        :: site[c].owner[n] == c && owner[n] == c -> awaited[n] = false; lease[n] = LEASE; site[c].unconfirmed[n] = false
        :: else -> skip
        fi;
        n++
      :: else -> break
      od

  /* The server dies once, and comes back with its journal. */
  :: up && !crashed ->
      up = false;
      crashed = true;
      n = 1;
      do
      :: n <= 3 -> cut(n); n++
      :: else -> break
      od
  :: !up ->
      up = true;
      recovering = LEASE;
      n = 0;
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
    :: skip
    fi;
    c = 0; p = 0; n = 0; q = 0; e = 0; o = 0; answers = false
    }
  od
}
