# SPDX-License-Identifier: Apache-2.0
# cmake -DNM=... -DLIBRARY=... -DEXPECTED=... -P check_exports.cmake
# Checks that the shared library exports the listed symbols and no others.
execute_process(COMMAND ${NM} -D --defined-only ${LIBRARY} OUTPUT_VARIABLE output RESULT_VARIABLE result)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "${NM} could not read ${LIBRARY}")
endif()
string(REGEX MATCHALL "[^\n]+" lines "${output}")
set(found "")
foreach(line IN LISTS lines)
  string(REGEX REPLACE "^[^ ]* *[A-Za-z] ([^@]*).*$" "\\1" symbol "${line}")
  if(NOT symbol STREQUAL "DOPPEL_0")  # the version's own name
    list(APPEND found ${symbol})
  endif()
endforeach()
list(SORT found)
file(STRINGS ${EXPECTED} expected REGEX "^[a-zA-Z]")
list(SORT expected)
set(missing ${expected})
list(REMOVE_ITEM missing ${found})
set(extra ${found})
list(REMOVE_ITEM extra ${expected})
if(missing OR extra)
  message(FATAL_ERROR "exports differ from ${EXPECTED}\n missing: ${missing}\n not listed: ${extra}\n"
    "A symbol that left breaks programs; a new one belongs in the list.")
endif()
list(LENGTH found count)
message(STATUS "${count} symbols exported, as listed")
