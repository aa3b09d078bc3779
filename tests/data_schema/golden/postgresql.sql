CREATE OR REPLACE FUNCTION public.journal_is_append_only() RETURNS trigger LANGUAGE plpgsql AS $function$ BEGIN RAISE EXCEPTION 'the journal is only ever added to'; END $function$
CREATE TRIGGER journal_never_changed BEFORE DELETE OR UPDATE OR TRUNCATE ON public.journal FOR EACH STATEMENT EXECUTE FUNCTION journal_is_append_only()
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
column $1.$2 $3$4
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
index $8
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
rule $5.$6 $7
