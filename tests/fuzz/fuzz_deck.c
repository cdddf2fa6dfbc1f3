/* fuzz_deck.c: decks. The echo of what was read is a deck whose echo stays the same. */
#include "fuzz.h"
#include "model/state.h"
#include "slipdisk/deck.h"
#include "model/model.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  char *text = fuzz_text(data, size);
  sd_model *m = fuzz_load(text, 0, NULL);
  if (m) {
    sd_model *again = fuzz_load(sd_model_deck(m)->full, 0, NULL);
    assert(again); /* its echo has no remarks on what is a default */
    sd_model *third = fuzz_load(sd_model_deck(again)->full, 0, NULL);
    assert(third && strcmp(sd_model_deck(third)->full, sd_model_deck(again)->full) == 0);
    sd_model_free(again);
    sd_model_free(third);
  }
  sd_model_free(m);
  free(text);
  return 0;
}
