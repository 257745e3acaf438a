#!/bin/bash
# oclgrind_test.sh STAGES_TEST: runs every kernel under oclgrind, which must have nothing to say, a check on each core.
# oclgrind's exit status is the program's, so the log decides. Unoptimised, because oclgrind 21.10 knows neither `freeze` nor
# scoped noalias.
set -euo pipefail
stages_test=$1

# check MOST_POINTS FILTER OPTIONS...
check() {
  local most=$1 filter=$2 log
  shift 2
  log=$(mktemp)
  if ! STAGES_TEST_MAX_POINTS=$most oclgrind "$@" --build-options -cl-opt-disable --log "$log" \
       "$stages_test" --gtest_brief=1 --gtest_filter="$filter" > "$log.out" 2>&1 || [[ -s $log ]]; then
    cat "$log.out" "$log"
    echo "oclgrind_test: failed with $* for $filter" >&2
    rm -f "$log" "$log.out"
    return 255 # xargs starts no more
  fi
  rm -f "$log" "$log.out"
}
export -f check
export stages_test

kernels='*Stage.*:FusedStages.*:Pack.*:Estimator.AgreesWithTheReferenceForEverySize/*'
searching='PlaneMatching.*:SymmetricIncrement.*:GeneralizedIncrement.*:Objective.WithoutAScale*:NormalEstimation.AreThose*:NormalEstimation.WherePoints*'

# The most points, which tests, and oclgrind's options: the longest first.
checks() {
  echo "130 Matching.EverySize*:NeighbourSearching.EverySize*:$searching --data-races --check-api"
  echo "130 $kernels --data-races --check-api"
  # More than one block of points.
  echo "2049 FusedStages.CountEveryPairOnce/*:CentroidStage.SumsOfSmallIntegersAreExact/* --data-races --check-api"
  echo "600 PlaneStage.IncrementIsThatOfTheReferenceForEverySize/* --data-races --check-api"
  # oclgrind takes the halves of 16-wide vectors and what the host maps and writes for uninitialised in part, so the chunked
  # shape and the host's search are left out here.
  echo "130 Matching.EverySize*Grouped*DeviceTree:NeighbourSearching.EverySize*Grouped* --uninitialized"
  # A process for each test: in a buffer that takes a freed one's place, oclgrind 21.10 knows only the old one's size.
  local suite= line
  while read -r line _; do
    if [[ $line == *. ]]; then
      suite=$line
    else
      echo "130 $suite$line --uninitialized"
    fi
  done < <(oclgrind "$stages_test" --gtest_list_tests --gtest_filter="${kernels%:*}:NormalEstimation.FarFrom*Grouped*" |
    grep -v '^Running main')
}

checks | xargs -P "$(nproc)" -L 1 bash -c 'check "$@"' check
